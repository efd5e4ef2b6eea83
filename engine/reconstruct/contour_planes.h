#pragma once

#include "slicemorph/conventions.h"

#include <string>

namespace slicemorph {

using openvdb::Vec2d;

/// The closed contours of an object on one plane. x, y and normal have unit length, x cross y = normal.
struct PlaneContours {
  Vec3d origin{0, 0, 0}, normal{0, 0, 1}, x{1, 0, 0}, y{0, 1, 0};
  /// World units from `origin` along x and y; the first point is not repeated at the end.
  std::vector<std::vector<Vec2d>> loops;

  Vec3d toWorld(const Vec2d& p) const { return origin + p[0] * x + p[1] * y; }
  Vec2d toPlane(const Vec3d& p) const { return {(p - origin).dot(x), (p - origin).dot(y)}; }
  double height(const Vec3d& p) const { return (p - origin).dot(normal); }
};

/// A plane without contours. x and y depend on the normal only.
PlaneContours planeAt(const Vec3d& origin, const Vec3d& normal);

/// One object, given by its contours on planes in any position. A plane without loops states that the object
/// is absent there.
struct ContourSet {
  std::string name;
  int label = 1;
  std::vector<PlaneContours> planes;
};

}  // namespace slicemorph
