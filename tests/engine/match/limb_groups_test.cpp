// Limbs as lines with radii: how they are paired, where stubs lie, and that swinging limbs keep their length.
#include "engine/match/limb_groups.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

namespace slicemorph {
namespace {

constexpr int kPoints = 13, kAround = 5;

/// From a root on: evenly spaced points in a direction that turns by `bend` radians from
/// piece to piece about z.
PlacedLimb limbOf(const Vec3d& root, double angle, double length, double bend = 0, double radius = 0.1) {
  PlacedLimb limb;
  Vec3d p = root;
  for (int i = 0; i < kPoints; ++i) {
    limb.chart.push_back(p);
    limb.radius.push_back(radius);
    p += length / (kPoints - 1) * Vec3d(std::cos(angle), std::sin(angle), 0);
    angle += bend;
  }
  limb.middle = limb.chart, limb.length = length;
  return limb;
}

Displacements stillMap() {
  const Lattice lattice = Lattice::over({Vec3d(-3), Vec3d(3)}, 0.5);
  return {lattice, std::vector<VectorField>(2, VectorField(lattice.count(), openvdb::Vec3s(0.f)))};
}

/// The middle line of a group of points, without those around it.
std::vector<Vec3d> lineOf(const std::vector<Correspondence>& points) {
  std::vector<Vec3d> line;
  for (size_t i = 0; i < points.size(); i += kAround) line.push_back(points[i].middle);
  return line;
}

/// Half way between two directions the limb is as long as they are: the chord of a straight mean would be
/// shorter by the cosine of half the angle.
TEST(LimbGroups, LimbsSwing) {
  const double swing = M_PI / 3;
  const auto points = limbPoints({limbOf({1, 2, 3}, -swing, 2), limbOf({1, 2, 3}, swing, 2)});
  const std::vector<Vec3d> line = lineOf(points);
  ASSERT_EQ(line.size(), size_t(kPoints));
  for (int i = 0; i < kPoints; ++i)
    EXPECT_LE((line[size_t(i)] - Vec3d(1 + 2.0 * i / (kPoints - 1), 2, 3)).length(), 1e-9) << i;
}

/// Lengths, roots and bends are the mean of theirs: half way between straight and bent is bent half as much.
TEST(LimbGroups, LimbsBendHalfAsMuch) {
  const double bend = 0.12;
  const auto points = limbPoints({limbOf({0, 0, 0}, 0.3, 1), limbOf({0, 2, 0}, 0.3, 2, bend)});
  const std::vector<Vec3d> line = lineOf(points), wanted = limbOf({0, 1, 0}, 0.3, 1.5, bend / 2).chart;
  for (int i = 0; i < kPoints; ++i) EXPECT_LE((line[size_t(i)] - wanted[size_t(i)]).length(), 1e-9) << i;
}

/// Four points around each of the line's, across it and at the limb's radius: on the objects their own, in
/// the middle the mean.
TEST(LimbGroups, PointsLieAroundTheLine) {
  const std::vector<PlacedLimb> limbs{limbOf({0, 0, 0}, 0.2, 1, 0.05, 0.1),
                                      limbOf({0, 0, 1}, 1.1, 2, -0.1, 0.3)};
  const auto points = limbPoints(limbs);
  ASSERT_EQ(points.size(), size_t(kPoints * kAround));
  for (int i = 0; i < kPoints; ++i)
    for (int n = 1; n < kAround; ++n) {
      const Correspondence &on = points[size_t(i * kAround)], &off = points[size_t(i * kAround + n)];
      EXPECT_NEAR((off.middle - on.middle).length(), 0.2, 1e-9);
      for (size_t k = 0; k < 2; ++k) {
        const Vec3d around = off.at[k] - on.at[k];
        EXPECT_LE((on.at[k] - limbs[k].chart[size_t(i)]).length(), 1e-9);
        EXPECT_NEAR(around.length(), limbs[k].radius[size_t(i)], 1e-9);
        const size_t piece = size_t(std::min(i, kPoints - 2));
        EXPECT_NEAR(around.dot(limbs[k].chart[piece + 1] - limbs[k].chart[piece]), 0, 1e-9);
      }
    }
}

Fields spheres() {
  return Fields(2, shapes::fieldOf(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1.2), 0.05));
}

/// Limbs stand all round a ball; on the second object they come in another order and a little displaced.
TEST(LimbGroups, PartnersAreTheNearest) {
  std::vector<std::vector<PlacedLimb>> limbs(2);
  std::vector<size_t> order{3, 0, 4, 1, 2};
  for (int i = 0; i < 5; ++i) {
    const double a = 2 * M_PI * i / 5;
    limbs[0].push_back(limbOf(Vec3d(std::cos(a), std::sin(a), 0), a, 0.8 + 0.05 * i));
  }
  for (size_t i : order) {
    const double a = 2 * M_PI * double(i) / 5 + 0.15;
    limbs[1].push_back(limbOf(Vec3d(std::cos(a), std::sin(a), 0.1), a, 0.9));
  }
  const auto groups = groupLimbs(limbs, spheres(), {2, shapes::straightChart()}, stillMap(), 3);
  ASSERT_EQ(groups.size(), 5u);
  for (const LimbGroup& group : groups) {
    EXPECT_FALSE(group.grows);
    ASSERT_EQ(group.limb.size(), 2u);
    const Vec3d a = group.limb[0].chart[0], b = group.limb[1].chart[0];
    EXPECT_GT(a.dot(b), std::cos(0.2)) << a << " and " << b;
  }
}

/// A limb that only one object has is a stub in the other one: short, and wholly below the surface where the
/// limb would leave it.
TEST(LimbGroups, ALimbWithoutPartnerIsAStub) {
  const PlacedLimb limb = limbOf({1, 0, 0}, 0, 1);
  const Fields fields = spheres();
  for (size_t has : {0u, 1u}) {
    std::vector<std::vector<PlacedLimb>> limbs(2);
    limbs[has] = {limb};
    const auto groups = groupLimbs(limbs, fields, {2, shapes::straightChart()}, stillMap(), 3);
    ASSERT_EQ(groups.size(), 1u);
    EXPECT_TRUE(groups[0].grows);
    ASSERT_EQ(groups[0].limb.size(), 2u);
    EXPECT_EQ(groups[0].limb[has].chart, limb.chart);
    const PlacedLimb& stub = groups[0].limb[1 - has];
    ASSERT_EQ(stub.chart.size(), limb.chart.size());
    for (const Vec3d& p : stub.chart) {
      EXPECT_LT(p.length(), 1) << p;
      // Across by less than a node of the coarse distances.
      EXPECT_LE(std::hypot(p[1], p[2]), 0.1) << p;
    }
    EXPECT_GT(stub.chart.back()[0], stub.chart.front()[0]);
    EXPECT_LE((stub.chart.back() - stub.chart.front()).length(), 0.35 * limb.length);
    EXPECT_LT(stub.radius[0], limb.radius[0]);
  }
}

/// Where there is no body to take it, it is left out.
TEST(LimbGroups, AFarAwayLimbIsLeftOut) {
  const std::vector<std::vector<PlacedLimb>> limbs{{limbOf({2, 0, 0}, 0, 0.5)}, {}};
  EXPECT_TRUE(groupLimbs(limbs, spheres(), {2, shapes::straightChart()}, stillMap(), 3).empty());
}

/// A ball with two rods: their lines in the chart, and in the middle space where the map takes them from.
TEST(LimbGroups, LimbsArePlacedByTheMap) {
  const double h = 0.04, scale = 0.5;
  const shapes::Distance creature =
      shapes::joined({shapes::sphere({0, 0, 0}, 0.5), shapes::capsule({-1.4, 0, 0}, {1.4, 0, 0}, 0.12)});
  const Fields fields(
      2, shapes::fieldOf(creature, openvdb::BBoxd(Vec3d(-1.7, -0.7, -0.7), Vec3d(1.7, 0.7, 0.7)), h));
  const std::vector<Chart> charts{shapes::straightChart({0, 0, 0}, scale),
                                  shapes::straightChart({0, 0, 0}, scale)};
  const Vec3d aside(0, 0.25, 0);
  const Lattice lattice = Lattice::over({Vec3d(-4), Vec3d(4)}, 0.5);
  Displacements map{lattice,
                    std::vector<VectorField>(2, VectorField(lattice.count(), openvdb::Vec3s(aside)))};
  for (openvdb::Vec3s& v : map.of[1]) v = -v;
  const auto placed = placedLimbs(fields, charts, map);
  for (size_t k = 0; k < 2; ++k) {
    ASSERT_EQ(placed[k].size(), 2u);
    for (const PlacedLimb& limb : placed[k]) {
      // The tip is a node of the coarse distances, a voxel apart here.
      const Vec3d tip = scale * limb.chart.back();
      EXPECT_LE((tip - Vec3d(std::copysign(1.52, tip[0]), 0, 0)).length(), 2 * h);
      double length = 0;
      for (size_t i = 0; i < limb.chart.size(); ++i) {
        EXPECT_LE((limb.middle[i] - (limb.chart[i] + (k == 0 ? -aside : aside))).length(), 1e-3) << i;
        if (i > 0) length += (limb.chart[i] - limb.chart[i - 1]).length();
      }
      EXPECT_NEAR(limb.length, length, 1e-3);
      EXPECT_NEAR(scale * limb.radius[size_t(kPoints / 2)], 0.12, h);
    }
    EXPECT_LT(placed[k][0].chart.back()[0] * placed[k][1].chart.back()[0], 0);
  }
}

}  // namespace
}  // namespace slicemorph
