#include "engine/rebuild/active_blocks.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

/// Reference: whether a box overlaps a block of 8 x 8 x 8 voxels with an active one, by looking
/// at every voxel.
bool meetsAny(const FloatGrid& grid, const openvdb::BBoxd& box) {
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    openvdb::CoordBBox voxels;
    it.getBoundingBox(voxels);
    for (auto c = voxels.begin(); c; ++c) {
      bool meets = true;
      for (int a = 0; a < 3; ++a) {
        const double low = (*c)[a] & ~7;
        meets &= box.max()[a] >= low && box.min()[a] < low + 8;
      }
      if (meets) return true;
    }
  }
  return false;
}

TEST(ActiveBlocks, AgreeWithLookingAtAllVoxels) {
  FloatGrid::Ptr grid = FloatGrid::create(0.f);
  std::mt19937 random(7);
  for (int n = 0; n < 12; ++n)
    grid->tree().setValue({int(random() % 80) - 40, int(random() % 80) - 40, int(random() % 80) - 40}, 1.f);
  grid->tree().addTile(1, {24, 24, 24}, 1.f, true);
  grid->tree().setValueOff({-100, 0, 0}, 3.f);  // a leaf without active voxels
  const ActiveBlocks blocks(grid->tree());
  std::uniform_real_distribution<> position(-60, 60), side(0, 24);
  int met = 0;
  for (int n = 0; n < 400; ++n) {
    const Vec3d low(position(random), position(random), position(random));
    const openvdb::BBoxd box(low, low + Vec3d(side(random), side(random), side(random)));
    EXPECT_EQ(blocks.meets(box), meetsAny(*grid, box)) << low;
    met += blocks.meets(box);
  }
  EXPECT_GT(met, 10);
  EXPECT_TRUE(blocks.meets({Vec3d(30), Vec3d(31)}));
}

TEST(ActiveBlocks, AnEmptyGridIsMetNowhere) {
  EXPECT_FALSE(ActiveBlocks(FloatGrid::create(0.f)->tree()).meets({Vec3d(-100), Vec3d(100)}));
}

}  // namespace
}  // namespace slicemorph
