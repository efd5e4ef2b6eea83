#pragma once

#include "slicemorph/conventions.h"

#include <memory>

namespace slicemorph {

/// Shape of a spine: turn rates of its coordinate frame along it, in the frame's own directions (about the
/// spine: twist; about e1 and e2: bending), in radians per chart unit, at stations evenly spaced over z0 in
/// [-half, half]. Beyond these the spine is straight. Copies share one table.
class Bend {
 public:
  /// Odd, so that one is at z0 = 0; twice as dense as the slices of fitSpine.
  static constexpr int kStations = 129;
  Bend() = default;  ///< straight
  Bend(double half, std::vector<Vec3d> rates);

  bool straight() const { return !table_; }
  double half() const;
  /// At the stations; zeros where straight.
  std::vector<Vec3d> rates() const;
  double stationZ0(int i) const { return half() * (2.0 * i / (kStations - 1) - 1); }

  /// A point of the spine, relative to point and frame at z0 = 0, chart units.
  struct Point {
    Vec3d point;
    Mat3d frame;  ///< columns: spine direction, e1, e2
    Vec3d rate;   ///< turn rate
  };
  Point at(double z0) const;
  /// Mean of the spine's points.
  Vec3d middle() const;
  /// z0 of the station nearest to a point.
  double nearest(const Vec3d& point) const;

 private:
  struct Table;
  std::shared_ptr<const Table> table_;
};

/// Chart of one object, Phi(z) -> world. Chart coordinates z = (z0, x, y): z0 runs along the spine, (x, y)
/// lie in the slice plane. All three have the same unit, about one radius of the object, so that lengths and
/// angles are nearly comparable between objects. The objects reach over z0 in [-half length, half length],
/// see Frames::halfLength. A straight spine gives parallel slices, a bent one slices that lean.
struct Chart {
  Vec3d center{0, 0, 0};           ///< world; of the spine at z0 = 0
  Mat3d axes = Mat3d::identity();  ///< columns: spine direction, e1, e2 at z0 = 0; a rotation
  Vec3d scale{1, 1, 1};            ///< world units per chart unit, per axis
  Bend bend;

  Vec3d toWorld(const Vec3d& z) const;
  /// Inverse of toWorld; where slices cross, in the slice of the spine's nearest point.
  Vec3d toChart(const Vec3d& p) const;
  /// Unit normal in chart space of a surface with the world normal `n` at a chart point.
  Vec3d normalToChart(const Vec3d& z, const Vec3d& n) const;
  /// Distance between neighbouring slices at a chart point over that at the spine; zero or
  /// less where slices cross.
  double spread(const Vec3d& z) const;
  /// World units per chart unit, geometric mean of the axes.
  double meanScale() const { return std::cbrt(scale[0] * scale[1] * scale[2]); }
};

/// The in-between's chart: the spines' mean points, scales and turn rates (in the frame's own
/// directions) are interpolated linearly, rotations by their Karcher mean (slerp for two). So a bar that
/// bends keeps its length.
Chart blendCharts(const std::vector<Chart>& charts, const Weights& weights);

/// The same object's chart with the spine reversed (a half turn about e1).
Chart reversed(const Chart& chart);
/// The same object's chart with the frame turned about the spine by `angle` radians everywhere.
Chart rolled(const Chart& chart, double angle);

/// Rotation vector (axis times angle in radians) of a rotation, and back.
Vec3d rotationVector(const Mat3d& rotation);
Mat3d rotationFromVector(const Vec3d& v);

}  // namespace slicemorph
