#include "engine/rebuild/sweep_band.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

constexpr double kBandVoxel = 0.1;

/// Fast sweeping is first order: half a voxel over a band, on a sphere of 20 voxels.
constexpr double kFirstOrder = 0.5;

void expectBand(const FloatGrid& grid, const shapes::Distance& shape, float band) {
  EXPECT_FLOAT_EQ(grid.background(), band);
  EXPECT_EQ(grid.getGridClass(), openvdb::GRID_LEVEL_SET);
  double most = 0;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    EXPECT_LT(std::abs(*it), band);
    most = std::max(most, std::abs(double(*it) - shape(grid.indexToWorld(it.getCoord()))) / kBandVoxel);
  }
  EXPECT_LE(most, kFirstOrder);
  // The whole band, in every direction of the surface normal.
  size_t missing = 0;
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-30), openvdb::Coord(30)).begin(); c; ++c)
    missing += std::abs(shape(grid.indexToWorld(*c))) < double(band) - kFirstOrder * kBandVoxel &&
               !grid.tree().isValueOn(*c);
  EXPECT_EQ(missing, 0u);
}

TEST(SweepBand, AnyFunctionBecomesADistance) {
  const shapes::Distance sphere = shapes::sphere({0.02, 0, 0.03}, 2);
  FloatGrid::Ptr field = shapes::levelSet(sphere, shapes::cube({0, 0, 0}, 2.6), kBandVoxel);
  for (auto it = field->beginValueOn(); it; ++it) {
    const Vec3d p = field->indexToWorld(it.getCoord());
    it.setValue(float(sphere(p) * (2 + std::sin(3 * p[0]))));
  }
  const float band = float(2 * kBandVoxel);
  expectBand(*sweptLevelSet(*field, band), sphere, band);
}

TEST(SweepBand, ANarrowBandIsWidened) {
  const shapes::Distance sphere = shapes::sphere({0.02, 0, 0.03}, 2);
  const FloatGrid::Ptr narrow = shapes::levelSet(sphere, shapes::cube({0, 0, 0}, 2.6), kBandVoxel);
  const float band = float(5 * kBandVoxel);
  const FloatGrid::Ptr wide = widenedLevelSet(*narrow, 3, band);
  expectBand(*wide, sphere, band);
  // Existing values are kept except where they were swept anew: equal within the sweeping's error, and
  // identical at the surface.
  for (auto it = narrow->cbeginValueOn(); it; ++it)
    if (std::abs(*it) < 0.5 * kBandVoxel) {
      EXPECT_NEAR(wide->tree().getValue(it.getCoord()), *it, 1e-6);
    }
}

}  // namespace
}  // namespace slicemorph
