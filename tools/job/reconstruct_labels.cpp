#include "tools/job/reconstruct_labels.h"

#include "engine/measure/label_measures.h"
#include "engine/reconstruct/fill_gaps.h"
#include "engine/reconstruct/grey_slices.h"
#include "engine/reconstruct/label_level_set.h"
#include "engine/reconstruct/own_slices.h"
#include "engine/volume/image_shape.h"
#include "engine/volume/manifold.h"
#include "engine/volume/resample_image.h"
#include "engine/volume/voxelise.h"
#include "io/image/image_formats.h"
#include "io/image/label_values.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/structure_file.h"
#include "slicemorph/io/vdb_writer.h"
#include "tools/job/given_slices.h"
#include "tools/job/label_output.h"
#include "tools/job/option_values.h"
#include "tools/job/reconstruct_cross.h"
#include "tools/job/reconstruct_grey.h"
#include "tools/job/reconstruct_label_slabs.h"
#include "tools/job/surface_writer.h"

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

ImageFile imageOfJob(const ReconstructJob& job) {
  return job.held ? *std::get<std::shared_ptr<const ImageFile>>(job.held->content)
                  : readImage(job.input, job.image);
}

SparseLabels sparseLabels(const ReconstructJob& job, Image image, const LabelledSlices& labelled,
                          Notes notes) {
  const GivenSlices given = givenSlices(job, labelled, image.lattice);
  SparseLabels sparse{std::move(image), given, std::move(notes)};
  const int axis = sparse.given.axis;
  const std::vector<char>& found = labelled.along(axis);
  if (areFound(job)) {
    DrawnSlices drawn;
    const SliceLayout layout = layoutOf(sparse.image.lattice, axis);
    for (int at = 0; at < sparse.image.lattice.size[axis]; ++at)
      if (found[size_t(at)]) drawn.add({sparse.image.values, layout, at}, at);
    sparse.given = whatWasDrawn(std::move(sparse.given), labelled, drawn);
  }
  if (job.between > 0) {
    labelsOf(sparse.image);
    sparse.image = expandedStack(sparse.image, axis, job.between);
  }
  const Notes more = job.between > 0
                         ? Notes{{"reconstruct.given-slices", Severity::kNote, "", described(sparse.given)}}
                         : notesOf(sparse.given, found);
  sparse.notes.insert(sparse.notes.end(), more.begin(), more.end());
  return sparse;
}

/// Whether labelled slices along some axis lie in steps, as they cannot where slices across it are labelled, too.
bool inSteps(const LabelledSlices& labelled) {
  for (int axis = 0; axis < 3; ++axis) {
    const std::vector<char>& found = labelled.along(axis);
    const auto neighbours =
        std::adjacent_find(found.begin(), found.end(), [](char a, char b) { return a && b; });
    if (neighbours == found.end()) return true;
  }
  return false;
}

StackPlacement placeOf(const ImageLattice& lattice, int axis) {
  StackPlacement placement;
  placement.origin = lattice.origin;
  placement.stepX = lattice.step[axis == 0 ? 1 : 0];
  placement.stepY = lattice.step[axis == 2 ? 1 : 2];
  placement.along = lattice.step[axis].unit();
  return placement;
}

/// Surfaces of the labels of one group, each closed for itself.
void addSurfaces(const ReconstructJob& job, const Image& labels, const GivenSlices& given,
                 SurfaceWriter& writer, JobEvents& events) {
  RankedSlices ranked = rankSlices(labels, given);
  const std::vector<double> values = ranked.values;
  const SliceScores scores(std::move(ranked.stack));
  const StackPlacement placement = placeOf(labels.lattice, given.axis);
  for (size_t rank = 0; rank < values.size(); ++rank) {
    if (values[rank] == 0) continue;
    events.throwIfCancelled();
    const FloatGrid::Ptr field = labelLevelSet(scores, int(rank), placement);
    Structure structure;
    structure.number = int(values[rank]);
    structure.name = "label_" + formatNumber(values[rank]);
    structure.mesh = makeManifold(surfaceOf(*field)).mesh;
    if (isGridOutput(job.output)) {
      const Vec3d spacing = labels.lattice.spacing();
      structure.grid = voxelise(
          structure.mesh, job.voxelSize > 0 ? job.voxelSize : std::min({spacing[0], spacing[1], spacing[2]}));
      structure.grid->setGridClass(openvdb::GRID_LEVEL_SET);
    }
    writer.add(structure);
  }
}

void writeLabelSurfaces(const ReconstructJob& job, const SparseLabels& sparse, JobEvents& events) {
  std::string list;
  size_t count = 0;
  for (const double v : rankLabels(sparse.image, sparse.given))
    if (v != 0) list += (list.empty() ? "" : ", ") + formatNumber(v), ++count;
  SurfaceWriter writer(job, count, "labels " + list, events);
  const std::vector<LabelGroup> groups = groupsOf(sparse.given);
  for (size_t g = 0; g < groups.size(); ++g)
    if (groups[g].given.at.size() > 1)
      addSurfaces(job, groups.size() > 1 ? onlyGroup(sparse.image, groups, g) : sparse.image, groups[g].given,
                  writer, events);
  writeStructureReports(job.reports, job.input, writer.finish(), sparse.notes);
}

}  // namespace

void reconstructImage(const ReconstructJob& job, JobEvents& events) {
  if (!job.held && !job.takeImage && job.imageKind != ImageKind::kGrey && reconstructLabelSlabs(job, events))
    return;
  ImageFile file = imageOfJob(job);
  const size_t notes = file.notes.size();
  if (job.imageKind != ImageKind::kGrey) takeLabels(file.image, /*asked=*/true, file.notes);
  ValuesSeen seen;
  if (job.imageKind == ImageKind::kAuto) seen.add(file.image.values, file.image.lattice.size);
  const bool labels = job.imageKind == ImageKind::kLabels ||
                      (job.imageKind == ImageKind::kAuto && (isStatedLabels(file) || seen.looksDrawn()));
  if (!labels) {
    if (file.notes.size() > notes) file = imageOfJob(job);  // as it is, without rounding
    return reconstructGrey(job, std::move(file), events);
  }
  LabelledSlices labelled(file.image.lattice.size);
  try {
    labelled.add(file.image.values);
  } catch (const InputError& error) {
    throw InputError(job.input, error.what());
  }
  if (areFound(job) && job.axis < 0 && !inSteps(labelled) &&
      reconstructCross(job, file.image, file.header, file.notes, events))
    return;
  SparseLabels sparse = sparseLabels(job, std::move(file.image), labelled, std::move(file.notes));
  events.notes(about(job.input, sparse.notes));
  if (!isImageOutput(job.output) && !isStructureOutput(job.output))
    return writeLabelSurfaces(job, sparse, events);
  Image dense = interpolateLabels(std::move(sparse.image), sparse.given);
  writeLabelImage(job, std::move(dense), std::move(file.header), sparse.notes, events);
}

}  // namespace slicemorph
