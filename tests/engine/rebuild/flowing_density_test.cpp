#include "engine/rebuild/flowing_density.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

/// Values on 24 voxels a side.
template <typename Value>
FloatGrid::Ptr cube(const Value& value) {
  const FloatGrid::Ptr grid = FloatGrid::create(0.f);
  grid->setTransform(openvdb::math::Transform::createLinearTransform(0.5));
  auto accessor = grid->getAccessor();
  for (auto c = openvdb::CoordBBox::createCube(openvdb::Coord(0), 24).begin(); c; ++c)
    accessor.setValue(*c, float(value(*c)));
  return grid;
}

bool isOdd(const openvdb::Coord& c) { return (c[0] + c[1] + c[2]) & 1; }

/// What alternates from voxel to voxel is taken from the nearer frame, what is even stays blended. Six means over 3 voxels
/// leave (1/3)^18 of an alternating pattern, and of a constant all; looked at in the middle, away from the rim.
TEST(FlowingDensity, DetailOfTheNearer) {
  const double t = 0.25, nearer = t * t / (t * t + (1 - t) * (1 - t));
  const FloatGrid::Ptr blend = cube([](const auto&) { return 5; });
  const auto difference = cube([](const openvdb::Coord& c) { return 2 + (isOdd(c) ? 1 : -1); });
  takeNearerDetail(*blend, *difference, t);
  for (const openvdb::Coord& c : {openvdb::Coord(12), openvdb::Coord(12, 11, 12)})
    EXPECT_NEAR(blend->getConstAccessor().getValue(c), 5 + (nearer - t) * (isOdd(c) ? 1 : -1), 1e-5);
}

TEST(FlowingDensity, NothingHalfWayAndNothingNegative) {
  const FloatGrid::Ptr blend = cube([](const auto&) { return 0.1; });
  const auto difference = cube([](const openvdb::Coord& c) { return isOdd(c) ? 4 : -4; });
  takeNearerDetail(*blend, *difference, 0.5);
  EXPECT_EQ(blend->getConstAccessor().getValue(openvdb::Coord(12)), 0.1f);
  takeNearerDetail(*blend, *difference, 0.25);
  float least = 1;
  for (auto value = blend->cbeginValueOn(); value; ++value) least = std::min(least, *value);
  EXPECT_EQ(least, 0.f);
}

TEST(FlowingDensity, Totals) {
  const FloatGrid::Ptr grid = cube([](const auto&) { return 2; });
  EXPECT_NEAR(totalOf(*grid), 2 * 24 * 24 * 24 * 0.125, 1e-6);
  scaleToTotal(*grid, 100);
  EXPECT_NEAR(totalOf(*grid), 100, 1e-3);
  const openvdb::DoubleGrid doubles(*grid);
  EXPECT_NEAR(totalOf(doubles), 100, 1e-3);
  const FloatGrid::Ptr none = FloatGrid::create(0.f);
  scaleToTotal(*none, 100);
  EXPECT_EQ(totalOf(*none), 0);
}

}  // namespace
}  // namespace slicemorph
