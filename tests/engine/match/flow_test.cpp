// Points that move far: rigid motions have closed forms, and what flows can be followed back.
#include "engine/match/flow.h"

#include "engine/match/fold_guard.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kSpacing = 0.125;
const Lattice kFine = Lattice::over({Vec3d(-1.5), Vec3d(1.5)}, 0.1);

Displacements nothing(size_t objects) {
  return {kFine, std::vector<VectorField>(objects, VectorField(kFine.count(), openvdb::Vec3s(0.f)))};
}

/// A small ball of points around a position.
std::vector<Vec3d> ball(const Vec3d& middle) {
  std::vector<Vec3d> points{middle};
  for (int a = 0; a < 3; ++a)
    for (double side : {-0.2, 0.2}) {
      Vec3d p = middle;
      p[a] += side;
      points.push_back(p);
    }
  return points;
}

Vec3d turned(const Vec3d& p, double angle) {
  const double c = std::cos(angle), s = std::sin(angle);
  return {c * p[0] - s * p[1], s * p[0] + c * p[1], p[2]};
}

double farthestFrom(const Displacements& map, const std::vector<Correspondence>& points) {
  double most = 0;
  for (const Correspondence& c : points)
    for (size_t k = 0; k < c.at.size(); ++k)
      most = std::max(most, (c.middle + map.at(k, c.middle) - c.at[k]).length());
  return most;
}

/// It ends where all points are within a tenth of the fitted spacing; the steps were found on the coarse
/// lattice and are read off the fine one between its nodes.
constexpr double kArrived = 0.1 * kSpacing + 0.1 * kSpacing;

void expectInvertible(const Displacements& map, const std::vector<Correspondence>& points) {
  EXPECT_GT(leastRatio(map), 0);
  for (size_t k = 0; k < map.of.size(); ++k) {
    const MiddleGuess guess(map.lattice, map.of[k]);
    for (const Correspondence& c : points) {
      Vec3d s = guess.near(c.middle + map.at(k, c.middle));
      ASSERT_TRUE(toMiddle(map, k, c.middle + map.at(k, c.middle), s));
      EXPECT_LE((s - c.middle).length(), 0.05 * kFine.spacing);
    }
  }
}

TEST(Flow, NothingToDoIsNothingDone) {
  std::vector<Correspondence> points;
  for (const Vec3d& p : ball({0, 0, 0})) points.push_back({{p, p}, p});
  const Displacements map = flowed(nothing(2), points, {}, kSpacing, kFine);
  for (const VectorField& field : map.of)
    for (const openvdb::Vec3s& v : field) EXPECT_LE(v.length(), 1e-6f);
}

TEST(Flow, APushArrives) {
  const Vec3d shift(0.5, 0.2, 0);
  std::vector<Correspondence> points;
  for (const Vec3d& p : ball({0, 0, 0})) points.push_back({{p + shift, p - shift}, p});
  const Displacements map = flowed(nothing(2), points, {}, kSpacing, kFine);
  EXPECT_LE(farthestFrom(map, points), kArrived);
  expectInvertible(map, points);
}

/// Two balls turn around each other by a quarter turn, in opposite directions on the two objects.
TEST(Flow, BallsTurnRoundEachOther) {
  const double angle = M_PI / 4;
  std::vector<Correspondence> points;
  for (double side : {-0.6, 0.6})
    for (const Vec3d& p : ball({side, 0, 0})) points.push_back({{turned(p, angle), turned(p, -angle)}, p});
  const Displacements map = flowed(nothing(2), points, {}, kSpacing, kFine);
  EXPECT_LE(farthestFrom(map, points), kArrived);
  expectInvertible(map, points);
}

/// Points that must stay fixed do, while others pass them.
TEST(Flow, StillPointsStay) {
  std::vector<Correspondence> points;
  for (const Vec3d& p : ball({0, 0, 0})) points.push_back({{p + Vec3d(0.4, 0, 0), p - Vec3d(0.4, 0, 0)}, p});
  std::vector<Vec3d> still;
  for (double y : {-1.0, 1.0})
    for (double x : {-0.4, 0.0, 0.4}) still.emplace_back(x, y, 0);
  const Displacements map = flowed(nothing(2), points, still, kSpacing, kFine);
  EXPECT_LE(farthestFrom(map, points), kArrived);
  for (const Vec3d& s : still)
    for (size_t k = 0; k < 2; ++k) EXPECT_LE(map.at(k, s).length(), kArrived) << s;
}

/// On top of a map that has carried everything aside already: the flow comes first, then the map.
TEST(Flow, GoesOnFromAMap) {
  const Vec3d aside(0, 0, 0.3), shift(0.3, 0, 0);
  Displacements start = nothing(2);
  for (openvdb::Vec3s& v : start.of[0]) v = openvdb::Vec3s(aside);
  for (openvdb::Vec3s& v : start.of[1]) v = -openvdb::Vec3s(aside);
  std::vector<Correspondence> points;
  for (const Vec3d& p : ball({0, 0, 0})) points.push_back({{p + aside + shift, p - aside - shift}, p});
  EXPECT_LE(farthestFrom(flowed(start, points, {}, kSpacing, kFine), points), kArrived);
}

}  // namespace
}  // namespace slicemorph
