// Severed rods against the whole ones.
#include "engine/rebuild/rejoin_components.h"

#include "engine/volume/small_components.h"
#include "tests/support/same_values.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kRejoinVoxel = 0.1;
const openvdb::BBoxd kRejoinBox({-2.6, -0.8, -0.8}, {2.6, 0.8, 0.8});

bool always(const std::vector<Vec3d>&) { return true; }

/// A rod along x of this radius from -2 to 2; severed where `gap` is not 0, by flat ends so far apart.
FloatGrid::Ptr rod(double radius, double gap = 0) {
  const shapes::Distance whole = shapes::capsule({-2, 0, 0}, {2, 0, 0}, radius);
  if (gap == 0) return shapes::levelSet(whole, kRejoinBox, kRejoinVoxel);
  return shapes::levelSet(
      [=](const Vec3d& p) { return std::max(whole(p), 0.5 * gap - std::abs(p[0] - 0.3)); }, kRejoinBox,
      kRejoinVoxel);
}

/// What is joined is the whole rod to within a voxel: its depth is found from voxels.
TEST(RejoinComponents, ASeveredRodIsWholeAgain) {
  for (double radius : {0.15, 0.25}) {
    const FloatGrid::Ptr whole = rod(radius), severed = rod(radius, 0.3);
    ASSERT_EQ(countPieces(*severed), 2) << radius;
    EXPECT_EQ(rejoinComponents(*severed, 1, always).joints, 1) << radius;
    EXPECT_EQ(countPieces(*severed), 1) << radius;
    for (auto value = whole->cbeginValueOn(); value; ++value) {
      EXPECT_NEAR(severed->tree().getValue(value.getCoord()), *value, kRejoinVoxel) << value.getCoord();
    }
  }
}

TEST(RejoinComponents, WhatBelongsApartStaysApart) {
  const auto unchanged = [](double radius, double gap, int allowed, bool belongs) {
    const FloatGrid::Ptr before = rod(radius, gap), grid = before->deepCopy();
    return rejoinComponents(*grid, allowed, [=](const std::vector<Vec3d>&) { return belongs; }).joints == 0 &&
           sameValues(*grid, *before);
  };
  EXPECT_FALSE(unchanged(0.25, 0.3, 1, true));
  EXPECT_TRUE(unchanged(0.25, 0.3, 2, true)) << "so many pieces are allowed";
  EXPECT_TRUE(unchanged(0.25, 0.3, 1, false)) << "no object has a limb there";
  EXPECT_TRUE(unchanged(0.25, 0.8, 1, true)) << "wider than both narrow bands";
  EXPECT_TRUE(unchanged(0.08, 0.3, 1, true)) << "thinner than two voxels";
}

}  // namespace
}  // namespace slicemorph
