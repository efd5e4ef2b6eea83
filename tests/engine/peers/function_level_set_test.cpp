#include "engine/peers/function_level_set.h"

#include "engine/measure/measure.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kVoxel = 0.5;
/// Its faces lie between voxels.
const Vec3d kHalf(4.1, 5.1, 6.1);
const FunctionBox kBox{{-kHalf, kHalf}, kVoxel, "test"};

/// What reaches the faces of the box is cut off there: a whole box for a function that is negative everywhere. Its edges
/// are cut by less than half a voxel each way, and faces of a linear function lie where it is 0.
TEST(FunctionLevelSet, IsCutOffAtTheFacesOfItsBox) {
  const FloatGrid::Ptr grid = levelSetOfFunction(kBox, [] { return [](const Vec3d&) { return -100.0f; }; });
  const ShapeMeasures m = measureShape(*grid);
  const double exact = 8 * kHalf[0] * kHalf[1] * kHalf[2];
  const double edges = 8 * (kHalf[0] + kHalf[1] + kHalf[2]), corner = kVoxel * kVoxel / 2;
  EXPECT_EQ(m.pieces, 1);
  EXPECT_LE(m.volume, exact * (1 + 1e-5));
  EXPECT_GE(m.volume, exact - edges * corner);
}

/// A cylinder that goes through the box on both sides: its area of section times the height of the box.
TEST(FunctionLevelSet, ClosesAThroughGoingCylinder) {
  const double radius = 3.1;
  const FloatGrid::Ptr grid = levelSetOfFunction(
      kBox, [&] { return [&](const Vec3d& p) { return float(std::hypot(p[0], p[1]) - radius); }; });
  const ShapeMeasures m = measureShape(*grid);
  EXPECT_EQ(m.pieces, 1);
  // Linear interpolation moves a curved wall by at most h^2 / (8 r) in, rims are cut by up to half a square voxel.
  const double exact = M_PI * radius * radius * 2 * kHalf[2];
  const double wall = 2 * M_PI * radius * 2 * kHalf[2] * kVoxel * kVoxel / (8 * radius) * 3;
  const double rims = 2 * 2 * M_PI * radius * kVoxel * kVoxel / 2;
  EXPECT_NEAR(m.volume, exact, wall + rims);
}

}  // namespace
}  // namespace slicemorph
