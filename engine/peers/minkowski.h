#pragma once

#include "engine/peers/ring_mesh.h"
#include "engine/volume/distance_field.h"
#include "slicemorph/progress.h"

#include <memory>
#include <vector>

namespace slicemorph {

struct MinkowskiOptions {
  /// Directions per right angle, of latitude and longitude, in which convex objects are measured.
  int directions = 32;
};

/// Morph by weighted Minkowski sums [KR91]: all points w_0 a + w_1 b + ... with a of the first object, b of the second and
/// so on. Of convex objects (whose hull is larger by less than a hundredth of their volume) the sum is made of the points
/// furthest out in each direction, which add. Otherwise it is the union of one object at every point of the surface of
/// the other: every voxel near the sum looks for the nearest of about 8,000 copies of either.
class MinkowskiMorph {
 public:
  /// `voxelSize`: world units. Throws GeometryError for a level set without surface; Cancelled.
  MinkowskiMorph(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                 const MinkowskiOptions& options = {}, Progress* progress = nullptr);
  /// A level set named "surface". Throws InputError unless there is one weight per object, for weights below 0, and where
  /// objects that are not convex need more than kMostVoxels.
  FloatGrid::Ptr frame(const Weights& weights) const;

  static constexpr double kMostVoxels =
      128.0 * 128 * 128;  ///< of the sum's box, other than of convex objects

 private:
  FloatGrid::Ptr convexSum(const Weights& weights) const;
  FloatGrid::Ptr gridSum(const Weights& weights) const;

  double voxelSize_;
  RingLayout layout_;  ///< of directions
  std::vector<std::shared_ptr<const DistanceField>> fields_;
  std::vector<std::vector<openvdb::Vec3s>> furthest_;  ///< surface points per object and direction
  bool convex_ = true;                                 ///< all are
};

}  // namespace slicemorph
