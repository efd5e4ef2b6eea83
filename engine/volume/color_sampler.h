#pragma once

#include "slicemorph/conventions.h"

#include <optional>

namespace slicemorph {

/// Weighted mean of colours. If all colours are equal it is exactly that colour, without rounding.
class ColorMean {
 public:
  void add(const openvdb::Vec3s& color, double weight);
  double weight() const { return sum_; }
  std::optional<openvdb::Vec3s> value() const;

 private:
  Vec3d first_{0, 0, 0}, more_{0, 0, 0};
  double sum_ = 0;
};

/// Samples a grid of colours. Values that are not finite count as missing. Each task needs its own.
class ColorSampler {
 public:
  explicit ColorSampler(const openvdb::Vec3SGrid& grid)
      : transform_(grid.transformPtr()), values_(grid.getConstAccessor()) {}

  /// Trilinear mean of the active voxels around a point in index space; its weight is their share, 0 to 1.
  ColorMean between(const Vec3d& index) const;
  /// Colour of the nearest active voxel within four voxels; none if there is none.
  std::optional<openvdb::Vec3s> nearest(const Vec3d& index) const;
  /// At a world point: between() if any voxel around is active, else nearest().
  std::optional<openvdb::Vec3s> at(const Vec3d& world) const;
  Vec3d toIndex(const Vec3d& world) const { return transform_->worldToIndex(world); }

 private:
  openvdb::math::Transform::ConstPtr transform_;
  openvdb::Vec3SGrid::ConstAccessor values_;
};

bool isColor(const openvdb::Vec3s& color);

}  // namespace slicemorph
