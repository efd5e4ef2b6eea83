#include "engine/blend/swing_paths.h"

#include "slicemorph/conventions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Everything turns about the origin, by `angle` radians one way to the first object and the other way to the second.
LatticeOnObjects turning(double angle, const Vec3d& scale) {
  LatticeOnObjects on;
  on.lattice = Lattice{Vec3d(-1, -1, -1), 0.25, openvdb::Coord(9)};
  on.charts.resize(2);
  for (Chart& chart : on.charts) chart.scale = scale;
  on.chart.assign(2, VectorField(on.lattice.count()));
  for (size_t k = 0; k < 2; ++k) {
    const Mat3d turn = rotationFromVector((k == 0 ? -angle : angle) * Vec3d(0, 0, 1));
    for (int z = 0; z < 9; ++z)
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x)
          on.chart[k][on.lattice.index(x, y, z)] =
              openvdb::Vec3s(turn * (scale * on.lattice.position(x, y, z)) / scale);
  }
  return on;
}

/// The largest distance of nodes from where they are when the turn goes at even speed, in distances from the axis; of
/// nodes so far from it that their path is off a straight line by a twentieth of the lattice's diagonal at least.
double worstOf(const LatticeOnObjects& on, double angle, bool arcs) {
  const SwingPaths paths(on);
  double worst = 0;
  for (double t : {0.1, 0.25, 0.5, 0.8}) {
    const VectorField offsets = paths.offsets({1 - t, t});
    const Weights path = pathWeights({1 - t, t});
    const Mat3d turn = rotationFromVector(angle * (2 * t - 1) * Vec3d(0, 0, 1));
    for (int z = 0; z < 9; ++z)
      for (int y = 0; y < 9; ++y)
        for (int x = 0; x < 9; ++x) {
          const size_t i = on.lattice.index(x, y, z);
          const Vec3d middle = on.lattice.position(x, y, z), scale = on.charts[0].scale;
          Vec3d at = (1 - path[0] - path[1]) * middle + path[0] * Vec3d(on.chart[0][i]) +
                     path[1] * Vec3d(on.chart[1][i]);
          if (arcs && !offsets.empty()) at += Vec3d(offsets[i]);
          const Vec3d wanted = turn * (scale * middle);
          const double radius = std::hypot(wanted[0], wanted[1]);
          const double diagonal = (scale * Vec3d(2.0)).length();
          if (radius * (1 - std::cos(angle)) > 0.0501 * diagonal)
            worst = std::max(worst, (scale * at - wanted).length() / radius);
        }
  }
  return worst;
}

/// A hinge that turns by 115 to 180 degrees in all: the arcs are those of the turn, to the floats of the map; parabolas are
/// farther off the farther it turns.
TEST(SwingPaths, ATurnIsATurnAtAllTimes) {
  for (const Vec3d& scale : {Vec3d(1.0), Vec3d(2, 0.5, 1)})
    for (double degrees : {115.0, 140.0, 170.0, 180.0}) {
      const double angle = 0.5 * degrees * M_PI / 180;
      EXPECT_LT(worstOf(turning(angle, scale), angle, true), 2e-6) << degrees;
    }
  EXPECT_GT(worstOf(turning(1.48, Vec3d(1.0)), 1.48, false), 0.08);
}

/// Below 80 degrees a parabola is as good, and nothing has to be added to it: with half the turn a it is off by s sin a - sin
/// (s a), (s - s^3) a^3 / 6 and so a^3 / (9 sqrt 3) at most.
TEST(SwingPaths, SmallTurnsHaveNone) {
  const double angle = 0.69;
  EXPECT_TRUE(SwingPaths(turning(angle, Vec3d(1.0))).offsets({0.5, 0.5}).empty());
  EXPECT_LT(worstOf(turning(angle, Vec3d(1.0)), angle, false),
            1.01 * angle * angle * angle / (9 * std::sqrt(3.0)));
}

/// The objects themselves stay as they are, to the last bit.
TEST(SwingPaths, NothingIsAddedAtTheObjects) {
  const LatticeOnObjects on = turning(1.4, Vec3d(1.0));
  const SwingPaths paths(on);
  EXPECT_TRUE(paths.offsets({1, 0}).empty());
  EXPECT_TRUE(paths.offsets({0, 1}).empty());
  EXPECT_FALSE(paths.offsets({0.3, 0.7}).empty());
}

}  // namespace
}  // namespace slicemorph
