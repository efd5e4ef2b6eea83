#pragma once

#include "slicemorph/conventions.h"

#include <openvdb/tools/SignedFloodFill.h>

#include <algorithm>
#include <cmath>
#include <functional>

/// Small shapes with closed-form answers: signed distance functions and their level sets.
namespace slicemorph::shapes {

using Distance = std::function<double(const Vec3d&)>;

inline Distance sphere(const Vec3d& centre, double radius) {
  return [=](const Vec3d& p) { return (p - centre).length() - radius; };
}

/// A torus around an axis along z.
inline Distance torus(const Vec3d& centre, double ring, double tube) {
  return [=](const Vec3d& p) {
    const Vec3d q = p - centre;
    return std::hypot(std::hypot(q[0], q[1]) - ring, q[2]) - tube;
  };
}

/// A box about the origin with half sides along x, y, z, whose edges are rounded with the radius `round`.
inline Distance box(const Vec3d& half, double round) {
  return [=](const Vec3d& p) {
    Vec3d q;
    for (int a = 0; a < 3; ++a) q[a] = std::abs(p[a]) - half[a] + round;
    const Vec3d out(std::max(q[0], 0.0), std::max(q[1], 0.0), std::max(q[2], 0.0));
    return out.length() + std::min(std::max({q[0], q[1], q[2]}), 0.0) - round;
  };
}

/// A rod with round ends.
inline Distance capsule(const Vec3d& a, const Vec3d& b, double radius) {
  return [=](const Vec3d& p) {
    const Vec3d ab = b - a;
    const double t = std::min(std::max((p - a).dot(ab) / ab.lengthSqr(), 0.0), 1.0);
    return (p - a - t * ab).length() - radius;
  };
}

/// The union of the parts.
inline Distance joined(const std::vector<Distance>& parts) {
  return [=](const Vec3d& p) {
    double d = 1e30;
    for (const Distance& part : parts) d = std::min(d, part(p));
    return d;
  };
}

/// The shape scaled, then rotated, then moved.
inline Distance placed(const Distance& shape, const Mat3d& rotation, const Vec3d& offset, double scale = 1) {
  const Mat3d back = rotation.transpose();
  return [=](const Vec3d& p) { return scale * shape(back * (p - offset) / scale); };
}

/// Level set of a distance function inside `box` (world units), with voxel size `h`.
inline FloatGrid::Ptr levelSet(const Distance& distance, const openvdb::BBoxd& box, double h) {
  const float band = float(kHalfWidth * h);
  auto grid = FloatGrid::create(band);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(h));
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("surface");
  const openvdb::Coord low = openvdb::Coord::floor(box.min() / h / 8.0) - openvdb::Coord(1);
  const openvdb::Coord high = openvdb::Coord::floor(box.max() / h / 8.0) + openvdb::Coord(1);
  auto accessor = grid->getAccessor();
  for (auto leaf = openvdb::CoordBBox(low, high).begin(); leaf; ++leaf) {
    const openvdb::Coord origin((*leaf)[0] * 8, (*leaf)[1] * 8, (*leaf)[2] * 8);
    if (std::abs(distance(h * (origin.asVec3d() + Vec3d(3.5)))) > (kHalfWidth + 6.1) * h) continue;
    for (auto c = openvdb::CoordBBox::createCube(origin, 8).begin(); c; ++c) {
      const double d = distance(h * (*c).asVec3d());
      if (std::abs(d) < band) accessor.setValue(*c, float(d));
    }
  }
  openvdb::tools::signedFloodFill(grid->tree());
  return grid;
}

inline openvdb::BBoxd cube(const Vec3d& centre, double half) {
  return {centre - Vec3d(half), centre + Vec3d(half)};
}

/// The level set of a ball.
inline FloatGrid::Ptr ball(double voxelSize, double radius, const Vec3d& centre = Vec3d(0.0)) {
  return levelSet(sphere(centre, radius), cube(centre, radius + 2 * kHalfWidth * voxelSize), voxelSize);
}

}  // namespace slicemorph::shapes
