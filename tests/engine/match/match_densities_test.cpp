#include "engine/match/match_densities.h"

#include "engine/match/fold_guard.h"
#include "slicemorph/conventions.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

namespace slicemorph {
namespace {

/// Soft balls of smoke of several sizes, none of which repeats.
double smokeAt(const Vec3d& p) {
  static const double balls[][4] = {{0, 0, 0, 5},    {7, 3, -2, 3},   {-6, 5, 3, 4},  {2, -8, 5, 3},
                                    {-3, -5, -7, 4}, {9, -4, 6, 2.5}, {-9, -2, -1, 2}};
  double sum = 0;
  for (const auto& b : balls) {
    const double r = (p - Vec3d(b[0], b[1], b[2])).length() / b[3];
    sum += r < 1.5 ? std::exp(-2 * r * r) - std::exp(-4.5) : 0;
  }
  return std::max(sum, 0.0);
}

/// The smoke as it is when points have moved: `back` leads from where they are now to where they were.
FloatGrid::ConstPtr smoke(const std::function<Vec3d(const Vec3d&)>& back) {
  const FloatGrid::Ptr grid = FloatGrid::create(0.f);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  auto accessor = grid->getAccessor();
  for (auto c = openvdb::CoordBBox::createCube(openvdb::Coord(-23), 46).begin(); c; ++c)
    if (const double d = smokeAt(back((*c).asVec3d())); d > 1e-3) accessor.setValue(*c, float(d));
  return grid;
}

const DensityVelocities kUnknown{};

/// Of a turn about z, by 7 radians per unit of time; at voxels' middles, or staggered at their faces, where they are the
/// same, as a component does not change along its own axis.
openvdb::Vec3SGrid::ConstPtr turningVelocity(bool staggered) {
  const openvdb::Vec3SGrid::Ptr grid = openvdb::Vec3SGrid::create();
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  if (staggered) grid->setGridClass(openvdb::GRID_STAGGERED);
  auto accessor = grid->getAccessor();
  for (auto c = openvdb::CoordBBox::createCube(openvdb::Coord(-25), 50).begin(); c; ++c) {
    const Vec3d p = (*c).asVec3d();
    accessor.setValue(*c, openvdb::Vec3s(float(-3.5 * p[1]), float(3.5 * p[0]), 0.f));
  }
  return grid;
}

/// A map that leaves everything where it is.
Displacements still(const Chart& chart) {
  const Lattice lattice =
      Lattice::over({Vec3d(-20) / chart.scale[0], Vec3d(20) / chart.scale[0]}, 1 / chart.scale[0]);
  return {lattice, {VectorField(lattice.count()), VectorField(lattice.count())}};
}

/// How far points of the smoke, given half way, are from where they should be on either object, in voxels, in the mean.
/// `motion(p, t)`: where what was at p at the time 0 is at t, in voxels.
double meanError(const Displacements& map, const Chart& chart,
                 const std::function<Vec3d(const Vec3d&, double)>& motion) {
  double sum = 0, weights = 0;
  for (auto c = openvdb::CoordBBox::createCube(openvdb::Coord(-14), 28).begin(); c; ++c) {
    const Vec3d p = (*c).asVec3d();
    const double weight = smokeAt(p);
    if (weight < 0.05) continue;
    const Vec3d middle = chart.toChart(0.5 * motion(p, 0.5));
    for (size_t k = 0; k < 2; ++k)
      sum += weight * (2.0 * chart.toWorld(middle + map.at(k, middle)) - motion(p, double(k))).length();
    weights += 2 * weight;
  }
  return sum / weights;
}

Chart chartOf() {
  Chart chart;
  chart.center = Vec3d(1, -0.5, 0.25), chart.axes = rotationFromVector({0, 0, 0.4}), chart.scale = Vec3d(3);
  return chart;
}

/// 5 voxels along a diagonal, at once and from a map that knows nothing: a tenth of a voxel.
TEST(MatchDensities, AMotionAlongALine) {
  const Vec3d by(3, -3, 2.6);
  const Chart chart = chartOf();
  const DensityMatch match = matchDensities(
      {smoke([](const Vec3d& p) { return p; }), smoke([&](const Vec3d& p) { return Vec3d(p - by); })},
      kUnknown, chart, still(chart));
  EXPECT_LT(meanError(match.map, chart, [&](const Vec3d& p, double t) { return Vec3d(p + t * by); }), 0.1);
  EXPECT_LT(match.after, 0.05);
  EXPECT_GT(match.before, 10 * match.after);
  EXPECT_GT(leastRatio(match.map), 0.1);
}

/// A turn by 40 degrees, up to 8 voxels: half a voxel, a quarter of the lattice's spacing, as round balls do not show how they
/// turn themselves.
TEST(MatchDensities, ATurn) {
  const double angle = 40 * M_PI / 180;
  const auto turned = [](const Vec3d& p, double a) { return Vec3d(rotationFromVector({0, 0, a}) * p); };
  const Chart chart = chartOf();
  const DensityMatch match = matchDensities(
      {smoke([](const Vec3d& p) { return p; }), smoke([&](const Vec3d& p) { return turned(p, -angle); })},
      kUnknown, chart, still(chart));
  EXPECT_LT(meanError(match.map, chart, [&](const Vec3d& p, double t) { return turned(p, t * angle); }), 0.5);
  EXPECT_GT(leastRatio(match.map), 0.1);
}

/// A turn by 140 degrees is too far for a search, which lays balls on other ones. The velocities tell it, in whatever
/// unit: to a voxel, half the lattice's spacing, of ways of up to 24.
TEST(MatchDensities, VelocitiesTellWhatIsTooFar) {
  const double angle = 140 * M_PI / 180;
  const auto turned = [](const Vec3d& p, double a) { return Vec3d(rotationFromVector({0, 0, a}) * p); };
  const auto motion = [&](const Vec3d& p, double t) { return turned(p, t * angle); };
  const Chart chart = chartOf();
  const std::array<FloatGrid::ConstPtr, 2> densities{
      smoke([](const Vec3d& p) { return p; }), smoke([&](const Vec3d& p) { return turned(p, -angle); })};
  const DensityMatch blind = matchDensities(densities, kUnknown, chart, still(chart));
  EXPECT_GT(meanError(blind.map, chart, motion), 3);
  for (bool staggered : {false, true}) {
    const openvdb::Vec3SGrid::ConstPtr velocity = turningVelocity(staggered);
    const DensityMatch match = matchDensities(densities, {velocity, velocity}, chart, still(chart));
    EXPECT_LT(meanError(match.map, chart, motion), 1) << staggered;
    EXPECT_LT(match.after, 0.5 * blind.after) << staggered;
    EXPECT_GT(leastRatio(match.map), 0.1) << staggered;
  }
  // What one object alone tells, or nonsense, changes nothing.
  const DensityMatch half = matchDensities(densities, {turningVelocity(false), nullptr}, chart, still(chart));
  EXPECT_EQ(half.map.of[0], blind.map.of[0]);
  const openvdb::Vec3SGrid::Ptr wrong = openvdb::Vec3SGrid::create(openvdb::Vec3s(0.f, 0.f, NAN));
  const DensityMatch nonsense = matchDensities(densities, {wrong, wrong}, chart, still(chart));
  EXPECT_EQ(nonsense.map.of[0], blind.map.of[0]);
}

/// Smoke that falls as it drifts: half way it has done a quarter of its fall, a voxel less than half. Nothing but the
/// velocities at both ends can tell; what lies there has the same accuracy as AMotionAlongALine.
TEST(MatchDensities, VelocitiesTellHowPathsBend) {
  const auto motion = [](const Vec3d& p, double t) { return Vec3d(p + Vec3d(5 * t, 0, -4 * t * t)); };
  const Chart chart = chartOf();
  const auto falling = [](float speed) {  // per third of the time
    const openvdb::Vec3SGrid::Ptr grid = openvdb::Vec3SGrid::create(openvdb::Vec3s(7.5f, 0.f, -3 * speed));
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    return grid;
  };
  const std::array<FloatGrid::ConstPtr, 2> densities{
      smoke([](const Vec3d& p) { return p; }),
      smoke([&](const Vec3d& p) { return Vec3d(p + Vec3d(-5, 0, 4)); })};
  const DensityMatch blind = matchDensities(densities, kUnknown, chart, still(chart));
  EXPECT_NEAR(meanError(blind.map, chart, motion), 1, 0.1);
  const DensityMatch match = matchDensities(densities, {falling(0), falling(4)}, chart, still(chart));
  EXPECT_LT(meanError(match.map, chart, motion), 0.1);
  // Velocities that have nothing to do with what happens bend nothing.
  const DensityMatch other =
      matchDensities(densities, {turningVelocity(false), turningVelocity(false)}, chart, still(chart));
  EXPECT_NEAR(meanError(other.map, chart, motion), 1, 0.1);
}

/// The same fall where eddies of the moment, of 8 voxels and faster than the drift, add to the velocities of both ends and leave
/// nothing behind: averaged over as many voxels as their waves have they are gone, and the time is that of the fall. A
/// fifth of a voxel; taken as they are, for the time that fits their size, they leave more than half a voxel.
TEST(MatchDensities, EddiesOfAMomentBendNothing) {
  const auto motion = [](const Vec3d& p, double t) { return Vec3d(p + Vec3d(5 * t, 0, -4 * t * t)); };
  const Chart chart = chartOf();
  const auto swirling = [](double speed, double phase) {
    const openvdb::Vec3SGrid::Ptr grid = openvdb::Vec3SGrid::create();
    grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
    const double wave = 2 * M_PI / 8, fast = 10;
    for (auto c = openvdb::CoordBBox::createCube(openvdb::Coord(-36), 72).begin(); c; ++c) {
      const Vec3d at = wave * (*c).asVec3d() + Vec3d(phase);
      const Vec3d v(7.5 + fast * std::sin(at[1]), fast * std::sin(at[2]), fast * std::sin(at[0]) - 3 * speed);
      grid->tree().setValue(*c, openvdb::Vec3s(v));
    }
    return grid;
  };
  const DensityMatch match =
      matchDensities({smoke([](const Vec3d& p) { return p; }),
                      smoke([&](const Vec3d& p) { return Vec3d(p + Vec3d(-5, 0, 4)); })},
                     {swirling(0, 0), swirling(4, 2)}, chart, still(chart));
  EXPECT_LT(meanError(match.map, chart, motion), 0.2);
}

/// Either density may be called the first: what belongs together is the same.
TEST(MatchDensities, OrderDoesNotCount) {
  const Vec3d by(2, 1, -2);
  const Chart chart = chartOf();
  const FloatGrid::ConstPtr a = smoke([](const Vec3d&p) { return p; }),
                            b = smoke([&](const Vec3d&p) { return Vec3d(p - by); });
  const DensityMatch one = matchDensities({a, b}, kUnknown, chart, still(chart)),
                     other = matchDensities({b, a}, kUnknown, chart, still(chart));
  double most = 0;
  for (size_t i = 0; i < one.map.of[0].size(); ++i)
    most = std::max(most, double((one.map.of[0][i] - other.map.of[1][i]).length()));
  // Sums in another order, in single precision.
  EXPECT_LT(most, 1e-3 * one.map.lattice.spacing);
}

/// A map that lays the densities on each other already stays.
TEST(MatchDensities, AGoodMapStays) {
  const Vec3d by(4, 0, 0);
  const Chart chart = chartOf();
  Displacements exact = still(chart);
  for (size_t k = 0; k < 2; ++k)
    for (auto& d : exact.of[k])
      d = openvdb::Vec3s(chart.toChart((k == 0 ? -0.25 : 0.25) * by) - chart.toChart(Vec3d(0.0)));
  const DensityMatch match = matchDensities(
      {smoke([](const Vec3d& p) { return p; }), smoke([&](const Vec3d& p) { return Vec3d(p - by); })},
      kUnknown, chart, exact);
  EXPECT_LE(match.after, match.before);
  EXPECT_LT(meanError(match.map, chart, [&](const Vec3d& p, double t) { return Vec3d(p + t * by); }), 0.02);
}

}  // namespace
}  // namespace slicemorph
