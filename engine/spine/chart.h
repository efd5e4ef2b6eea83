#pragma once

#include "engine/conventions.h"

#include <openvdb/math/Quat.h>

namespace slicemorph {

/// Chart of one object, Phi(z) -> world, about a straight spine: parallel slices. Chart coordinates z = (z0, x, y):
/// z0 runs along the spine, (x, y) lie in the slice plane, and all three have the same unit, about one radius, so that
/// lengths and angles mean nearly the same for every object; u = z0 / aspect, where the aspect is the objects' common
/// half length in those units. A curved spine is another Phi behind the same two functions.
struct Chart {
  Vec3d center{0, 0, 0};  ///< world
  Mat3d axes = Mat3d::identity();  ///< columns: spine direction, e1, e2; a rotation
  Vec3d scale{1, 1, 1};   ///< world units per chart unit, per axis

  Vec3d toWorld(const Vec3d& z) const { return center + axes * (scale * z); }
  Vec3d toChart(const Vec3d& p) const { return (axes.transpose() * (p - center)) / scale; }
  /// Direction of a surface normal in chart space, unit.
  Vec3d normalToChart(const Vec3d& n) const { return (scale * (axes.transpose() * n)).unit(); }
  /// World units per chart unit, in the mean.
  double meanScale() const { return std::cbrt(scale[0] * scale[1] * scale[2]); }
};

/// The in-between chart: centres and lengths linear, rotations by their weighted mean on the rotation group (slerp
/// for two; Karcher mean for more).
Chart blendCharts(const std::vector<Chart>& charts, const Weights& weights);

/// Rotation vector (axis times angle in radians) of a rotation, and back.
Vec3d rotationVector(const Mat3d& rotation);
Mat3d rotationFromVector(const Vec3d& v);

}  // namespace slicemorph
