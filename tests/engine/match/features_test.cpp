// How an artist's points, lines and disks become correspondences; what they do to a morph:
// engine/features_test.
#include "engine/match/features.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kScale = 0.5;

Fields twoBalls() {
  return Fields(2, shapes::fieldOf(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1.2), 0.05));
}

/// The second chart lies elsewhere and is turned about z by a quarter.
std::vector<Chart> twoCharts() {
  Chart second = shapes::straightChart({0.2, 0, 0.1}, kScale);
  second.axes = rotationFromVector({0, 0, M_PI / 2});
  return {shapes::straightChart({0, 0, 0}, kScale), second};
}

Feature point(const std::string& name, const Vec3d& a, const Vec3d& b) {
  return {name, Feature::Kind::kPoint, {{a}, {b}}};
}

TEST(FeaturePoints, PointsAreMarksInTheirCharts) {
  const std::vector<Chart> charts = twoCharts();
  const Vec3d a(0.9, 0.1, 0), b(0, 0.9, -0.1);
  const FeaturePoints placed = placeFeatures({point("nose", a, b)}, twoBalls(), charts);
  ASSERT_EQ(placed.marks.size(), 1u);
  EXPECT_TRUE(placed.lines.empty());
  const Vec3d own = a / kScale, other = charts[1].axes.transpose() * (b - charts[1].center) / kScale;
  EXPECT_LE((placed.marks[0].at[0] - own).length(), 1e-12);
  EXPECT_LE((placed.marks[0].at[1] - other).length(), 1e-12);
  EXPECT_LE((placed.marks[0].middle - 0.5 * (own + other)).length(), 1e-12);
}

/// A disk's centre, a point on either side at half its radius, and eight on its rim, at right angles to its
/// normal and none of them spun against the other object's.
TEST(FeaturePoints, DisksAreAStarOfMarks) {
  Feature disk{"ring", Feature::Kind::kDisk, {{{0.5, 0, 0}}, {{0, 0.6, 0}}}};
  disk.normals = {{2, 0, 0}, {0, 5, 0}}, disk.radii = {0.3, 0.4};
  const std::vector<Chart> charts(2, shapes::straightChart({0, 0, 0}, kScale));
  const FeaturePoints placed = placeFeatures({disk}, twoBalls(), charts);
  ASSERT_EQ(placed.marks.size(), 11u);
  const Mat3d turn = rotationFromVector({0, 0, M_PI / 2});  // the least that takes one normal to the other
  for (size_t k = 0; k < 2; ++k) {
    const Vec3d centre = kScale * placed.marks[0].at[k], normal = disk.normals[k].unit();
    EXPECT_LE((centre - disk.positions[k][0]).length(), 1e-9);
    for (size_t i = 1; i < placed.marks.size(); ++i) {
      const Vec3d off = kScale * placed.marks[i].at[k] - centre;
      EXPECT_NEAR(off.length(), (i < 3 ? 0.5 : 1) * disk.radii[k], 1e-9) << i;
      EXPECT_NEAR(std::abs(off.dot(normal)), i < 3 ? off.length() : 0, 1e-9) << i;
    }
  }
  for (size_t i = 1; i < placed.marks.size(); ++i) {
    const Vec3d a = placed.marks[i].at[0] - placed.marks[0].at[0],
                b = placed.marks[i].at[1] - placed.marks[0].at[1];
    EXPECT_LE((turn * a * (disk.radii[1] / disk.radii[0]) - b).length(), 1e-6) << i;
  }
}

Feature line(const std::string& name, const std::vector<Vec3d>& a, const std::vector<Vec3d>& b) {
  return {name, Feature::Kind::kLine, {a, b}};
}

/// Lines that join end to end on both objects become one, in whatever order they are given, starting at
/// the end that moves less.
TEST(FeaturePoints, LinesThatFollowAreOne) {
  const std::vector<Chart> charts(2, shapes::straightChart({0, 0, 0}, kScale));
  const Vec3d hip(0, 0, 0), knee[2] = {{0.4, 0, 0}, {0.3, 0.3, 0}}, foot[2] = {{0.8, 0, 0}, {0.3, 0.8, 0}};
  for (bool swapped : {false, true}) {
    std::vector<Feature> features{line("thigh", {hip, knee[0]}, {hip, knee[1]}),
                                  line("shin", {knee[0], foot[0]}, {knee[1], foot[1]})};
    if (swapped) std::swap(features[0], features[1]);
    const FeaturePoints placed = placeFeatures(features, twoBalls(), charts);
    for (size_t k = 0; k < 2; ++k) {
      ASSERT_EQ(placed.limbs[k].size(), 1u);
      EXPECT_LE((kScale * placed.limbs[k][0].chart.front() - hip).length(), 1e-9);
      EXPECT_LE((kScale * placed.limbs[k][0].chart.back() - foot[k]).length(), 1e-9);
    }
    EXPECT_EQ(placed.lines.size(), 5 * placed.limbs[0][0].chart.size());
  }
  // Given from the foot to the hip, it still starts at the hip.
  const FeaturePoints back = placeFeatures({line("leg", {foot[0], hip}, {foot[1], hip})}, twoBalls(), charts);
  EXPECT_LE(back.limbs[1][0].chart.front().length(), 1e-9);
}

/// The radius is the depth: for a line through a ball of radius 1, one minus the distance from the centre.
TEST(FeaturePoints, LinesAreAsThickAsTheyAreDeep) {
  const std::vector<Chart> charts(2, shapes::straightChart({0, 0, 0}, kScale));
  const std::vector<Vec3d> along{{0.1, 0, 0}, {0.7, 0, 0}};
  const PlacedLimb limb = placeFeatures({line("spike", along, along)}, twoBalls(), charts).limbs[0][0];
  for (size_t i = 0; i < limb.chart.size(); ++i)
    EXPECT_NEAR(kScale * limb.radius[i], 1 - kScale * limb.chart[i].length(), 0.02) << i;  // coarse distances
}

TEST(FeaturePoints, PlacesAlongALine) {
  const std::vector<Vec3d> bent{{0, 0, 0}, {3, 0, 0}, {3, 1, 0}};
  EXPECT_LE((pointAlong(bent, 0) - bent[0]).length(), 1e-12);
  EXPECT_LE((pointAlong(bent, 0.5) - Vec3d(2, 0, 0)).length(), 1e-9);
  EXPECT_LE((pointAlong(bent, 0.875) - Vec3d(3, 0.5, 0)).length(), 1e-9);
  EXPECT_LE((pointAlong(bent, 1) - bent[2]).length(), 1e-12);
  EXPECT_EQ(pointAlong({{7, 8, 9}}, 0.3), Vec3d(7, 8, 9));
}

PlacedLimb straightLimb(double y) {
  PlacedLimb limb;
  for (int i = 0; i < 13; ++i) limb.chart.emplace_back(0.1 * i, y, 0), limb.radius.push_back(0.1);
  limb.middle = limb.chart;
  return limb;
}

TEST(FeaturePoints, ALimbAlongALineIsPrescribed) {
  EXPECT_TRUE(isPrescribedBy(straightLimb(0), {straightLimb(2), straightLimb(0.14)}));
  EXPECT_FALSE(isPrescribedBy(straightLimb(0), {straightLimb(0.16)}));
  EXPECT_FALSE(isPrescribedBy(straightLimb(0), {}));
  // Closeness near the root alone does not count, as all limbs of a body meet there.
  PlacedLimb root = straightLimb(0);
  root.chart.resize(4);
  EXPECT_FALSE(isPrescribedBy(straightLimb(0), {root}));
}

TEST(FeaturePoints, WhatLiesFarFromAllSurfacesIsLeftOut) {
  // A tenth of the diagonal of a ball's box is 0.35.
  const auto [kept, notes] =
      featuresInReach({point("far", {1.5, 0, 0}, {0, 0, 1.5}), point("deep", {0, 0, 0}, {9, 9, 9}),
                       point("near", {9, 0, 0}, {0, 0, 1.2})},
                      twoBalls());
  ASSERT_EQ(kept.size(), 2u);
  EXPECT_EQ(kept[0].name, "deep");
  EXPECT_EQ(kept[1].name, "near");
  ASSERT_EQ(notes.size(), 1u);
  EXPECT_NE(notes[0].sentence().find("far"), std::string::npos);
}

Displacements constantMap(const Vec3d& first, const Vec3d& second) {
  const Lattice lattice = Lattice::over({Vec3d(-4), Vec3d(4)}, 0.5);
  return {lattice,
          {VectorField(lattice.count(), openvdb::Vec3s(first)),
           VectorField(lattice.count(), openvdb::Vec3s(second))}};
}

TEST(FeaturePoints, WhatAMapMeetsIsNoContradiction) {
  const std::vector<Chart> charts(2, shapes::straightChart({0, 0, 0}, kScale));
  const Vec3d shift(0.25, 0, 0);
  const Displacements map = constantMap(shift / kScale, -shift / kScale);
  EXPECT_TRUE(contradictions({point("nose", shift, -shift)}, charts, map, 2).empty());
  EXPECT_TRUE(contradictions({}, charts, map, 2).empty());
}

/// A feature is missed by half the distance on either side of the middle, in world units; two features that
/// would have to swap are named together.
TEST(FeaturePoints, WhatAMapMissesIsAWarning) {
  const std::vector<Chart> charts(2, shapes::straightChart({0, 0, 0}, kScale));
  const Displacements still = constantMap(Vec3d(0.0), Vec3d(0.0));
  const Vec3d a(0.3, 0, 0), b(-0.3, 0, 0);
  const Notes one = contradictions({point("nose", a, b)}, charts, still, 2);
  ASSERT_EQ(one.size(), 1u);
  EXPECT_EQ(one[0].code, "features.contradict");
  EXPECT_EQ(one[0].severity, Severity::kWarning);
  EXPECT_NE(one[0].text.find("'nose' is missed by 0.3 world units"), std::string::npos) << one[0].text;
  const Notes two = contradictions({point("left", a, b), point("right", b, a)}, charts, still, 2);
  ASSERT_EQ(two.size(), 1u);  // once for both
  EXPECT_NE(two[0].text.find("'left' and 'right'"), std::string::npos) << two[0].text;
}

}  // namespace
}  // namespace slicemorph
