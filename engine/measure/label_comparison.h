#pragma once

#include "slicemorph/image.h"
#include "slicemorph/measure.h"

#include <optional>

namespace slicemorph {

/// One label in two maps; world units.
struct LabelComparison {
  std::int64_t label = 0;
  size_t voxels[2] = {0, 0}, shared = 0;
  double volume[2] = {0, 0};
  Vec3d centroid[2] = {Vec3d(0.0), Vec3d(0.0)};  ///< of the voxels' centres; (0, 0, 0) where there are none
  double dice = 0;                               ///< 2 shared / (a + b)
  /// Between the outer voxels' centres (those with a neighbour over a face that is not of the label, or none), each to
  /// the nearest of the other map, both directions taken together; none where the label is in one map alone.
  std::optional<SurfaceDistance> distance;
};

/// Compares all labels but 0 that one of two maps on the same lattice has, ascending. The lattice's axes must be at right
/// angles, else InputError. Distances are exact [FH12].
std::vector<LabelComparison> compareLabels(const Image& a, const Image& b);

}  // namespace slicemorph
