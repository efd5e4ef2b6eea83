#pragma once

#include "engine/peers/full_fields.h"
#include "slicemorph/conventions.h"
#include "slicemorph/progress.h"
#include "slicemorph/slicemorph.h"

/// The classic alternatives to the slice method, for comparison.
namespace slicemorph {

/// Pointwise blend of full (unclamped) distance fields, sum_k w_k F_k(p), rebuilt as a level set.
class SdfBlend {
 public:
  /// Computes distance fields with voxels of `voxelSize` (world units) over the bounding box of all level
  /// sets. Throws InputError if that box has more than 2^31 voxels; the method needs all of them.
  SdfBlend(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize);
  /// A level set named "surface" (empty if the blend has no inside). Throws InputError unless there is one
  /// weight per level set.
  FloatGrid::Ptr frame(const Weights& weights) const;

 private:
  FullFields fields_;
};

/// Cross-dissolve: values are blended where they are, nothing moves. Weights as for MorphPlan::pullback().
/// There is no surface, so Pullback::colors() throws InputError except at weight 1.
Pullback dissolve(const Weights& weights);

/// Result of OpenVDB's LevelSetMorphing [BW01], [Mus11] from `source` to `target`.
struct LevelSetMorphResult {
  /// `count` frames named "surface": the first is the source, the last is where the front came to rest.
  std::vector<FloatGrid::Ptr> frames;
  /// Largest symmetric distance of the last frame to the target, voxels; infinite if the surface vanished.
  double restDistance = 0;
  int steps = 0;  ///< each a third of a time unit; one to two voxels far from the target
};

/// Runs until the surface is within half a voxel of the target everywhere (measured at the voxels next to it;
/// the exact `restDistance` may be slightly larger), stops moving, or `maxSteps` are used up. The frames have
/// the source's transform and are spread evenly over the steps, to within half the distance between recorded
/// steps. Throws InputError for `count` below 2; Cancelled.
LevelSetMorphResult levelSetMorph(const FloatGrid& source, const FloatGrid& target, int count,
                                  int maxSteps = 2000, Progress* progress = nullptr);

}  // namespace slicemorph
