#pragma once

#include "engine/volume/mesh_measures.h"

#include <cmath>

namespace slicemorph {

/// Distance from 0, in voxels, from which a shape's origin is taken out of its points: nearer ones are exact to .002 of
/// a voxel (half a step of single precision is 2^-25).
constexpr double kFarVoxels = 1 << 16;

/// What is taken out of the points of a shape with this box so that they keep their digits in single precision, in
/// whole numbers; 0 where it lies near enough for voxels of a size.
inline Vec3d farOrigin(const openvdb::BBoxd& box, double voxelSize) {
  if (box.empty() || !(farthestCoordinate(box) > kFarVoxels * voxelSize)) return Vec3d(0.0);
  const Vec3d centre = box.getCenter();
  return {std::round(centre[0]), std::round(centre[1]), std::round(centre[2])};
}

}  // namespace slicemorph
