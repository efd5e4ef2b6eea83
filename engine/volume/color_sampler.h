#pragma once

#include "slicemorph/conventions.h"

#include <optional>

namespace slicemorph {

/// Weighted mean of colours that is exactly the one colour where all are the same.
class ColorMean {
 public:
  void add(const openvdb::Vec3s& color, double weight);
  double weight() const { return sum_; }
  std::optional<openvdb::Vec3s> value() const;

 private:
  Vec3d first_{0, 0, 0}, more_{0, 0, 0};
  double sum_ = 0;
};

/// A grid of colours at places of its index space; values that are not finite count as none. For one task.
class ColorSampler {
 public:
  explicit ColorSampler(const openvdb::Vec3SGrid& grid)
      : transform_(grid.transformPtr()), values_(grid.getConstAccessor()) {}

  /// Trilinear between active voxels, with their share of the place (0 to 1) as weight.
  ColorMean between(const Vec3d& index) const;
  /// That of the nearest active voxel within four voxels; none where there is none.
  std::optional<openvdb::Vec3s> nearest(const Vec3d& index) const;
  /// Of a world point: the one, else the other.
  std::optional<openvdb::Vec3s> at(const Vec3d& world) const;
  Vec3d toIndex(const Vec3d& world) const { return transform_->worldToIndex(world); }

 private:
  openvdb::math::Transform::ConstPtr transform_;
  openvdb::Vec3SGrid::ConstAccessor values_;
};

bool isColor(const openvdb::Vec3s& color);

}  // namespace slicemorph
