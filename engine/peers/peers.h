#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/progress.h"
#include "slicemorph/slicemorph.h"

/// The classic alternatives, as honest peers to measure against.
namespace slicemorph {

/// Pointwise blend of full (unclamped) distance fields: sum_k w_k F_k(p), rebuilt to a level set.
class SdfBlend {
 public:
  /// Level sets by the conventions; distance fields are made once, on `voxelSize` (world units), over the box
  /// of all. Throws InputError where that box has more than 2^31 voxels: the method needs all of them.
  SdfBlend(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize);
  /// A level set named "surface" by the conventions (empty where the blend has no inside). Throws InputError
  /// for weights that are not one per level set.
  FloatGrid::Ptr frame(const Weights& weights) const;

 private:
  std::vector<FloatGrid::Ptr> fields_;  ///< every voxel of the box active, the same leaves in each
};

/// Cross-dissolve: values are blended where they are, nothing moves. Weights as MorphPlan::pullback(). It makes
/// no surface: Pullback::colors() throws InputError but at weight 1.
Pullback dissolve(const Weights& weights);

/// OpenVDB's LevelSetMorphing [BW01], [Mus11] from `source` to `target`.
struct LevelSetMorphResult {
  std::vector<FloatGrid::Ptr>
      frames;               ///< `count` frames, first = source, last = where it came to rest; "surface"
  double restDistance = 0;  ///< largest symmetric distance of the last frame to the target, voxels;
                            ///< infinite where the surface vanished
  int steps = 0;            ///< of a third of a time unit, one to two voxels far from the target
};

/// Runs until the surface is within half a voxel of the target everywhere (as the voxels next to it see it;
/// the exact `restDistance` may come out a little larger), it stops moving, or `maxSteps` are used up. Both
/// by the conventions; the frames have the source's transform. They are spread evenly over the steps, to
/// within a half of the distance between two of them. Throws InputError for `count` below 2, Cancelled.
LevelSetMorphResult levelSetMorph(const FloatGrid& source, const FloatGrid& target, int count,
                                  int maxSteps = 2000, Progress* progress = nullptr);

}  // namespace slicemorph
