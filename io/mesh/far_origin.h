#pragma once

#include "slicemorph/conventions.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

/// Distance from 0, in a shape's lengths, from which its origin is taken out of its points: nearer ones are exact to
/// .002 of a voxel at 1024 voxels along it (half a step of single precision is 2^-25).
constexpr double kFarAway = 64;

/// What is taken out of the points of a shape with this box so that they keep their digits in single precision, in
/// whole numbers; 0 where it lies near enough.
inline Vec3d farOrigin(const openvdb::BBoxd& box) {
  if (box.empty()) return Vec3d(0.0);
  double farthest = 0;
  for (int i = 0; i < 3; ++i) farthest = std::max({farthest, std::abs(box.min()[i]), std::abs(box.max()[i])});
  if (!(farthest > kFarAway * box.extents()[int(box.maxExtent())])) return Vec3d(0.0);
  const Vec3d centre = box.getCenter();
  return {std::round(centre[0]), std::round(centre[1]), std::round(centre[2])};
}

}  // namespace slicemorph
