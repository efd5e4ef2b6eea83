// What lies many lengths away from a body, and the ball from which a body grows.
#include "engine/volume/strays.h"

#include "engine/volume/seed.h"

#include <gtest/gtest.h>
#include <openvdb/tools/Composite.h>
#include <openvdb/tools/LevelSetSphere.h>

namespace slicemorph {
namespace {

constexpr float kVoxel = 0.1f;

FloatGrid::Ptr ball(double x, double radius) {
  return openvdb::tools::createLevelSetSphere<FloatGrid>(float(radius), openvdb::Vec3f(float(x), 0.f, 0.f),
                                                         kVoxel);
}

/// Level sets in one grid.
FloatGrid::Ptr together(FloatGrid::Ptr a, const FloatGrid::Ptr& b) {
  openvdb::tools::csgUnion(*a, *b);
  return a;
}

size_t insideCount(const FloatGrid& grid) {
  size_t count = 0;
  for (auto value = grid.cbeginValueAll(); value; ++value)
    if (*value < 0) count += value.getVoxelCount();
  return count;
}

TEST(Strays, AreFarAndSmall) {
  const FloatGrid::Ptr body = ball(0, 1), all = together(ball(0, 1), ball(300, 0.15));
  const Strays strays = findStrays(*all);
  EXPECT_EQ(strays.pieces, 1u);
  EXPECT_EQ(strays.body, body->evalActiveVoxelBoundingBox());
  const FloatGrid::Ptr kept = withoutStrays(*all, strays);
  EXPECT_EQ(kept->activeVoxelCount(), body->activeVoxelCount());
  // The inside of a ball without leaves of its own is filled again.
  EXPECT_EQ(insideCount(*kept), insideCount(*body));
}

TEST(Strays, AreNoneWhereAPieceIsNearOrLarge) {
  // A drop ten radii away, and a body as large as the other one far away.
  for (const FloatGrid::Ptr& grid :
       {together(ball(0, 1), ball(10, 0.15)), together(ball(0, 1), ball(300, 1)), ball(0, 1)}) {
    const Strays strays = findStrays(*grid);
    EXPECT_TRUE(strays.leaves.empty());
    EXPECT_EQ(strays.body, grid->evalActiveVoxelBoundingBox());
  }
  EXPECT_TRUE(findStrays(*FloatGrid::create(0.3f)).leaves.empty());
}

TEST(Seed, IsABallInside) {
  const FloatGrid::Ptr body = ball(5, 1), seed = seedIn(*body);
  EXPECT_EQ(seed->transform(), body->transform());
  EXPECT_EQ(seed->background(), body->background());
  // A ball of two voxels has 33 voxels within that distance, of which those at it are on the surface.
  EXPECT_EQ(insideCount(*seed), 27u);
  for (auto value = seed->cbeginValueAll(); value; ++value)
    if (*value < 0) EXPECT_LT(body->tree().getValue(value.getCoord()), 0);
}

}  // namespace
}  // namespace slicemorph
