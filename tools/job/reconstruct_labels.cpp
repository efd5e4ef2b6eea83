#include "tools/job/reconstruct_labels.h"

#include "engine/measure/label_measures.h"
#include "engine/reconstruct/label_level_set.h"
#include "engine/reconstruct/label_slices.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/manifold.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/voxelise.h"
#include "io/paths.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/option_values.h"
#include "tools/job/surface_writer.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// A stack of labels, and which of its slices are given.
struct SparseLabels {
  Image image;
  GivenSlices given;
  Notes notes;
};

/// The stack with `between` empty slices between every two.
Image expanded(const Image& stack, int axis, int between) {
  Image result;
  result.lattice = stack.lattice;
  const int gap = between + 1;
  result.lattice.size[axis] = (stack.lattice.size[axis] - 1) * gap + 1;
  result.lattice.step[axis] /= gap;
  std::visit(
      [&](const auto& from) {
        std::decay_t<decltype(from)> to(result.lattice.count(), 0);
        const openvdb::Coord n = stack.lattice.size;
        for (int k = 0; k < n[2]; ++k)
          for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
              openvdb::Coord at(i, j, k);
              at[axis] *= gap;
              to[result.lattice.index(at[0], at[1], at[2])] = from[stack.lattice.index(i, j, k)];
            }
        result.values = std::move(to);
      },
      stack.values);
  return result;
}

GivenSlices everySlice(int axis, int gap, int size) {
  GivenSlices given;
  given.axis = axis;
  for (int at = 0; at < size; at += gap) given.at.push_back(at);
  return given;
}

std::string described(const GivenSlices& given) {
  const int first = given.at.size() > 1 ? given.at[1] - given.at[0] : 0;
  const bool even = std::adjacent_find(given.at.begin(), given.at.end(),
                                       [&](int a, int b) { return b - a != first; }) == given.at.end();
  return std::to_string(given.at.size()) + " given slices along axis " + std::string(1, "ijk"[given.axis]) +
         (even ? ", every " + std::to_string(first) : ", unevenly") + ", from " +
         std::to_string(given.at.front()) + " to " + std::to_string(given.at.back());
}

SparseLabels readSparse(const ReconstructJob& job) {
  ImageFile file = readImage(job.input, job.image);
  SparseLabels sparse{std::move(file.image), {}, std::move(file.notes)};
  Image& image = sparse.image;
  if (job.between > 0) {
    const int axis = job.axis < 0 ? int(openvdb::math::MaxIndex(image.lattice.spacing())) : job.axis;
    if (image.lattice.size[axis] < 2)
      throw InputError(job.input + " has one slice along axis " + std::string(1, "ijk"[axis]) +
                       "; a surface needs two or more");
    labelsOf(image);
    image = expanded(image, axis, job.between);
    sparse.given = everySlice(axis, job.between + 1, image.lattice.size[axis]);
  } else {
    try {
      sparse.given = findGivenSlices(image, job.axis, job.every);
    } catch (const InputError& error) {
      throw InputError(job.input + ": " + error.what() +
                       "; --between N puts N slices between every two of a stack");
    }
  }
  sparse.notes.emplace_back("reconstruct.given-slices", Severity::kNote, "", described(sparse.given));
  return sparse;
}

StackPlacement placeOf(const ImageLattice& lattice, int axis) {
  StackPlacement placement;
  placement.origin = lattice.origin;
  placement.stepX = lattice.step[axis == 0 ? 1 : 0];
  placement.stepY = lattice.step[axis == 2 ? 1 : 2];
  placement.along = lattice.step[axis].unit();
  return placement;
}

void writeLabelSurfaces(const ReconstructJob& job, const SparseLabels& sparse, JobEvents& events) {
  RankedSlices ranked = rankSlices(sparse.image, sparse.given);
  const std::vector<double> values = ranked.values;
  const SliceScores scores(std::move(ranked.stack));
  const ImageLattice& lattice = sparse.image.lattice;
  const StackPlacement placement = placeOf(lattice, sparse.given.axis);
  std::string list;
  for (double v : values)
    if (v != 0) list += (list.empty() ? "" : ", ") + formatNumber(v);
  const size_t count = values.size() - size_t(std::count(values.begin(), values.end(), 0.0));
  SurfaceWriter writer(job, count, "labels " + list, events);
  for (size_t rank = 0; rank < values.size(); ++rank) {
    if (values[rank] == 0) continue;
    events.throwIfCancelled();
    const FloatGrid::Ptr field = labelLevelSet(scores, int(rank), placement);
    Structure structure;
    structure.number = int(values[rank]);
    structure.name = "label_" + formatNumber(values[rank]);
    structure.mesh = makeManifold(surfaceOf(*field)).mesh;
    if (extensionOf(job.output) == ".vdb") {
      const Vec3d spacing = lattice.spacing();
      structure.grid = voxelise(
          structure.mesh, job.voxelSize > 0 ? job.voxelSize : std::min({spacing[0], spacing[1], spacing[2]}));
      structure.grid->setGridClass(openvdb::GRID_LEVEL_SET);
    }
    writer.add(structure);
  }
  writeStructureReports(job.reports, job.input, writer.finish(), sparse.notes);
}

}  // namespace

void reconstructLabels(const ReconstructJob& job, JobEvents& events) {
  const SparseLabels sparse = readSparse(job);
  events.notes(about(job.input, sparse.notes));
  if (!isImageOutput(job.output)) return writeLabelSurfaces(job, sparse, events);
  Image dense = interpolateLabels(sparse.image, sparse.given);
  if (!job.like.empty()) dense = nearestTo(dense, readImage(job.like, job.image).image.lattice);
  writeImage(job.output, dense);
  events.fileWritten(job.output, false);
  if (job.reports.empty()) return;
  std::vector<StructureRow> rows;
  for (const LabelMeasures& m : measureLabels(dense)) rows.push_back(rowOf(m, job.output));
  writeStructureReports(job.reports, job.input, rows, sparse.notes);
}

}  // namespace slicemorph
