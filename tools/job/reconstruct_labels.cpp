#include "tools/job/reconstruct_labels.h"

#include "engine/measure/label_measures.h"
#include "engine/reconstruct/fill_gaps.h"
#include "engine/reconstruct/label_level_set.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/manifold.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/voxelise.h"
#include "io/image/label_values.h"
#include "io/paths.h"
#include "slicemorph/io/image_writer.h"
#include "tools/job/given_slices.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct_label_slabs.h"
#include "tools/job/surface_writer.h"
#include "tools/job/write_structures.h"

#include <algorithm>
#include <utility>

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
  Image result{expandedLattice(stack.lattice, axis, between), {}};
  std::visit(
      [&](const auto& from) {
        std::decay_t<decltype(from)> to(result.lattice.count(), 0);
        const openvdb::Coord n = stack.lattice.size;
        for (int k = 0; k < n[2]; ++k)
          for (int j = 0; j < n[1]; ++j)
            for (int i = 0; i < n[0]; ++i) {
              openvdb::Coord at(i, j, k);
              at[axis] *= between + 1;
              to[result.lattice.index(at[0], at[1], at[2])] = from[stack.lattice.index(i, j, k)];
            }
        result.values = std::move(to);
      },
      stack.values);
  return result;
}

SparseLabels readSparse(const ReconstructJob& job) {
  ImageFile file = readImage(job.input, job.image);
  SparseLabels sparse{std::move(file.image), {}, std::move(file.notes)};
  Image& image = sparse.image;
  takeLabels(image, /*asked=*/true, sparse.notes);
  LabelledSlices labelled(image.lattice.size);
  try {
    if (job.between > 0) labelsOf(image);
    labelled.add(image.values);
  } catch (const InputError& error) {
    throw InputError(job.input, error.what());
  }
  sparse.given = givenSlices(job, labelled, image.lattice);
  if (job.between > 0) image = expanded(image, sparse.given.axis, job.between);
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
  if (reconstructLabelSlabs(job, events)) return;
  SparseLabels sparse = readSparse(job);
  events.notes(about(job.input, sparse.notes));
  const bool structures = isStructureOutput(job.output);
  if (!isImageOutput(job.output) && !structures) return writeLabelSurfaces(job, sparse, events);
  Image dense = interpolateLabels(std::move(sparse.image), sparse.given);
  if (!job.like.empty()) dense = nearestTo(dense, readImage(job.like, job.image).image.lattice);
  const auto labels = std::make_shared<const Image>(std::move(dense));
  if (structures)
    events.notes(
        writeLabelStructures({job.input, job.output, job.source, job.like, job.names, job.image}, labels));
  else
    writeImage(job.output, *labels);
  events.fileWritten(job.output, false);
  if (job.reports.empty()) return;
  std::vector<StructureRow> rows;
  for (const LabelMeasures& m : measureLabels(*labels)) rows.push_back(rowOf(m, job.output));
  writeStructureReports(job.reports, job.input, rows, sparse.notes);
}

}  // namespace slicemorph
