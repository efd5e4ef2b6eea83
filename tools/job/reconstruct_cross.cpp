#include "tools/job/reconstruct_cross.h"

#include "engine/measure/label_measures.h"
#include "engine/reconstruct/contour_labels.h"
#include "engine/reconstruct/cross_slices.h"
#include "engine/volume/resample_image.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/image_writer.h"
#include "slicemorph/io/structure_file.h"
#include "tools/job/label_output.h"
#include "tools/job/surface_writer.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace slicemorph {
namespace {

/// Slices drawn by hand lie as far apart as their drawer liked: every gap is a gap.
constexpr double kEveryGap = 1e6;
constexpr double kMostNodes = 4e7;  ///< of a label's lattice, as of contours

std::string countsOf(const CrossLabel& label) {
  std::string text;
  for (int axis = 0; axis < 3; ++axis) {
    const auto count = std::count_if(label.slices.begin(), label.slices.end(),
                                     [&](const CrossSlice& slice) { return slice.axis == axis; });
    if (count > 0)
      text +=
          (text.empty() ? "" : ", ") + std::to_string(count) + " along axis " + std::string(1, "ijk"[axis]);
  }
  return text;
}

/// The map's own finest spacing, or larger where the label's lattice would get too large.
double voxelSizeOf(const ContourSet& set, const ImageLattice& lattice) {
  openvdb::BBoxd box;
  for (const PlaneContours& plane : set.planes)
    for (const auto& loop : plane.loops)
      for (const Vec2d& p : loop) box.expand(plane.toWorld(p));
  const Vec3d spacing = lattice.spacing(), size = box.extents() + Vec3d(8 * spacing.length());
  return std::max(std::min({spacing[0], spacing[1], spacing[2]}),
                  std::cbrt(size[0] * size[1] * size[2] / kMostNodes));
}

}  // namespace

bool reconstructCross(const ReconstructJob& job, const Image& labels, const ImageHeader& header,
                      const Notes& before, JobEvents& events) {
  const std::vector<CrossLabel> cross = findCrossSlices(labels);
  if (cross.empty()) return false;
  Notes notes = before;
  std::vector<ContourSurface> surfaces;
  std::vector<ContourSet> sets;
  std::vector<int> numbers;
  for (size_t n = 0; n < cross.size(); ++n) {
    const std::string name = "label " + std::to_string(cross[n].label);
    ContourSet set = outlinesOf(labels, cross[n]);
    ContourSurfaceOptions options;
    options.voxelSize = job.voxelSize > 0 ? job.voxelSize : voxelSizeOf(set, labels.lattice);
    options.bridgedGaps = kEveryGap;
    try {
      PartProgress own(events, double(n) / double(cross.size()), double(n + 1) / double(cross.size()));
      surfaces.push_back(contourSurface(set, options, &own));
    } catch (const GeometryError&) {
      notes.emplace_back("reconstruct.no-body", Severity::kWarning, name,
                         "is on one slice only, or on none: left as it is, nothing can be filled in");
      continue;
    }
    notes.emplace_back("reconstruct.given-slices", Severity::kNote, name,
                       "was drawn on slices across: " + countsOf(cross[n]));
    sets.push_back(std::move(set)), numbers.push_back(int(n) + 1);
  }
  events.notes(about(job.input, notes));
  if (surfaces.empty()) throw InputError(job.input, "no label has two slices to fill in between");
  if (!isImageOutput(job.output) && !isStructureOutput(job.output)) {
    SurfaceWriter writer(job, surfaces.size(), "labels", events);
    for (size_t i = 0; i < surfaces.size(); ++i)
      writer.add({sets[i].label, "label_" + std::to_string(sets[i].label), contourMesh(sets[i], surfaces[i]),
                  surfaces[i].grid});
    writeStructureReports(job.reports, job.input, writer.finish(), notes);
    return true;
  }
  const Image between = contourLabels(surfaces, numbers, labels.lattice, SharedVoxel::deepest);
  writeLabelImage(job, withGiven(labels, cross, between), header, notes, events);
  return true;
}

}  // namespace slicemorph
