#pragma once

#include "engine/frame/align.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

struct FeatureWarpOptions {
  /// Added to a feature's distance, so that on it its weight is great but finite; a share of the diagonal of the objects'
  /// common box.
  double nearness = 0.001;
};

/// Warp by pairs of features, then cross-dissolve [LGL95]; disks after [CJT96]. Each feature of the in-between (its
/// place, direction and size between the objects') carries all of space onto each object, as it lies to that object's
/// own; a point goes where the features' maps take it in the mean, by weights of one over the square of its distance to
/// them. The objects' distances there are blended. A point feature moves what is around it, a line turns it and stretches
/// it along the line, a disk turns it and scales it by its radius.
class FeatureWarp {
 public:
  /// `voxelSize`: world units. Throws InputError without features, for a line that has not the same number of places on
  /// all objects, and for options out of range.
  FeatureWarp(const std::vector<Object>& objects, double voxelSize, const std::vector<Feature>& features,
              const FeatureWarpOptions& options = {});
  /// A level set named "surface". Throws InputError unless there is one weight per object, and for too many voxels.
  FloatGrid::Ptr frame(const Weights& weights) const;
  /// Where a point of the in-between is on an object, world units; weights as for frame().
  Vec3d onObject(const Vec3d& point, const Weights& weights, size_t object) const;

  /// A feature's middle, directions and sizes as a chart: a line's first axis leads along it and is as long, a disk's
  /// first axis is its normal, its unit the radius.
  struct Element {
    Feature::Kind kind = Feature::Kind::kPoint;
    std::vector<Chart> on;  ///< per object
  };

 private:
  Fields fields_;
  std::vector<Element> elements_;
  double voxelSize_ = 0, nearness_ = 0;  ///< both world units
};

}  // namespace slicemorph
