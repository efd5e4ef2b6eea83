#pragma once

#include "engine/peers/full_fields.h"

namespace slicemorph {

/// Chosen by us: a ball that becomes itself stays within a tenth of its radius; among up to ten such balls, within a fifth.
struct BoundedBlendOptions {
  /// Length of the way through time from one object to another, in diagonals of the objects' box.
  double gap = 0.3;
  /// Share of that way for which each object lasts by itself, below 0.5.
  double stay = 0.25;
  /// The most that the blend adds, in gaps, where two objects are blended; of more objects in proportion.
  double strength = 0.75;
  /// How far from all objects' surfaces in space and time the blend is felt, relative to the bounding object's.
  double width = 3;
};

/// Union of functions that are positive inside, to which a displacement is added within a bounding object [PPK05]:
/// max_k f_k + most (1 - r^2)^3 / (1 + r^2) with r^2 = m / (m + bound^2), where m is the mean of (f_k / width)^2 by
/// weights. Outside the bounding object, where `bound` is not positive, it is the union and no more. The
/// mean is ours, so that any number can be blended and one of weight 0 counts for nothing.
double boundedUnion(const std::vector<double>& functions, const Weights& weights, double bound, double most,
                    double width);

/// Morph by space-time blending [PPK04]: each object is a cylinder in space and time (the intersection of the object with
/// a stretch of time, by an R-function), which ends a little after the object's own time; a bounded blend of their union
/// fills the gap between. The bounding object is the stretch between the objects' own times, no further than a gap from
/// the objects. At weight 1 an object is unchanged.
class BoundedBlend {
 public:
  /// Throws InputError where the box about the objects has more than 2^31 voxels; Cancelled. Keeps all voxels of that box
  /// for each object.
  BoundedBlend(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
               const BoundedBlendOptions& options = {}, Progress* progress = nullptr);
  /// A level set named "surface". Throws InputError unless there is one weight per level set.
  FloatGrid::Ptr frame(const Weights& weights) const;
  /// The way from one object to another, world units.
  double gap() const { return gap_; }

 private:
  FullFields fields_;
  BoundedBlendOptions options_;
  double gap_;
};

}  // namespace slicemorph
