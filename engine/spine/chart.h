#pragma once

#include "slicemorph/conventions.h"

#include <memory>

namespace slicemorph {

/// How a spine bends: turn rates of its frame along it, in the frame's own directions (about the spine:
/// twist; about e1 and e2: bending), in radians per chart unit, linear between stations evenly spread over z0
/// in [-half, half]. Beyond these the spine goes on straight. Copies share one table.
class Bend {
 public:
  static constexpr int kStations = 129;
  Bend() = default;  ///< straight
  Bend(double half, std::vector<Vec3d> rates);

  bool straight() const { return !table_; }
  double half() const;
  /// At the stations; zeros where straight.
  std::vector<Vec3d> rates() const;
  double stationPlace(int i) const { return half() * (2.0 * i / (kStations - 1) - 1); }

  /// Point of the spine and its frame at z0, from the frame and the place at z0 = 0, for unit speed.
  struct Place {
    Vec3d point;
    Mat3d frame;
    Vec3d rate;
  };
  Place at(double z0) const;
  /// Mean of the spine's points.
  Vec3d middle() const;
  /// z0 of the station nearest to a point.
  double nearest(const Vec3d& point) const;

 private:
  struct Table;
  std::shared_ptr<const Table> table_;
};

/// Chart of one object, Phi(z) -> world. Chart coordinates z = (z0, x, y): z0 runs along the spine, (x, y)
/// lie in the slice plane, and all three have the same unit, about one radius, so that lengths and angles
/// mean nearly the same for every object; u = z0 / aspect, where the aspect is the objects' common half
/// length in those units. A straight spine gives parallel slices, a bent one slices that lean.
struct Chart {
  Vec3d center{0, 0, 0};           ///< world; of the spine at z0 = 0
  Mat3d axes = Mat3d::identity();  ///< columns: spine direction, e1, e2 at z0 = 0; a rotation
  Vec3d scale{1, 1, 1};            ///< world units per chart unit, per axis
  Bend bend;

  Vec3d toWorld(const Vec3d& z) const;
  /// The nearest slice's coordinates, where slices cross.
  Vec3d toChart(const Vec3d& p) const;
  /// Direction in chart space of a surface normal at a chart point, unit.
  Vec3d normalToChart(const Vec3d& z, const Vec3d& n) const;
  /// How far the slices stand apart at a chart point against the spine; not above zero where they cross.
  double spread(const Vec3d& z) const;
  /// World units per chart unit, in the mean.
  double meanScale() const { return std::cbrt(scale[0] * scale[1] * scale[2]); }
};

/// The in-between chart: middles and lengths linear, rotations by their weighted mean on the rotation group
/// (slerp for two; Karcher mean for more), turn rates linear in the frame's own directions, so that a bar
/// bends like a bar.
Chart blendCharts(const std::vector<Chart>& charts, const Weights& weights);

/// The same object's chart with the spine the other way round (a half turn about e1).
Chart reversed(const Chart& chart);
/// With the frame turned about the spine by `angle` radians everywhere.
Chart rolled(const Chart& chart, double angle);

/// Rotation vector (axis times angle in radians) of a rotation, and back.
Vec3d rotationVector(const Mat3d& rotation);
Mat3d rotationFromVector(const Vec3d& v);

}  // namespace slicemorph
