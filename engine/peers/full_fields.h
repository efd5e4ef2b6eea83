#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/progress.h"

#include <functional>
#include <vector>

namespace slicemorph {

/// A function of the distances to several level sets: `distances` has the values of one leaf for each of them, `result`
/// takes as many.
using LeafFunction = std::function<void(const std::vector<const float*>& distances, float* result)>;

/// True (unclamped) distances to several level sets at every voxel of the box about them all.
class FullFields {
 public:
  static constexpr openvdb::Index kLeafValues = openvdb::FloatTree::LeafNodeType::SIZE;

  /// `voxelSize`: world units; `method`: for messages. Throws InputError if the box has more than 2^31 voxels; Cancelled.
  FullFields(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize, const char* method,
             Progress* progress = nullptr);
  /// One more level set, which must lie in the box.
  void add(const FloatGrid::ConstPtr& levelSet);

  size_t count() const { return fields_.size(); }
  /// Throws InputError unless there is one weight per level set of the constructor.
  void requireWeights(const Weights& weights) const;
  /// Level set named "surface" (empty without any inside) of the function's zero set. The function need be no distance, but
  /// change by no more than `steepest` voxels from voxel to voxel where it is near 0.
  FloatGrid::Ptr levelSetOf(const LeafFunction& function, double steepest = 1) const;

 private:
  std::vector<openvdb::Coord> origins_;
  size_t inputs_;
  std::vector<FloatGrid::Ptr> fields_;  ///< all voxels of the box are active; all fields have the same leaves
  openvdb::math::Transform::Ptr transform_;
};

/// Tells how far a plan is. Throws Cancelled; `progress` may be null.
void reportOrCancel(Progress* progress, const char* stage, double fraction);

}  // namespace slicemorph
