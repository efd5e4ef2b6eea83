#include "engine/peers/peers.h"

#include "engine/volume/level_set.h"
#include "slicemorph/errors.h"

#include <openvdb/tools/LevelSetSphere.h>

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

FloatGrid::Ptr unitSphere() {
  return openvdb::tools::createLevelSetSphere<FloatGrid>(1.f, openvdb::Vec3f(0.f), 0.1f);
}

/// The same colour on all active voxels of a level set.
openvdb::Vec3SGrid::Ptr painted(const FloatGrid& surface, const openvdb::Vec3s& color) {
  const auto grid = openvdb::Vec3SGrid::create(std::make_shared<openvdb::Vec3STree>(
      surface.tree(), openvdb::Vec3s(0.f), color, openvdb::TopologyCopy()));
  grid->setTransform(surface.transform().copy());
  return grid;
}

TEST(Dissolve, HasNoSurfaceWhoseColorsItCouldBlend) {
  const FloatGrid::Ptr sphere = unitSphere();
  const openvdb::Vec3SGrid::Ptr red = painted(*sphere, {1, 0, 0}), blue = painted(*sphere, {0, 0, 1});
  Pullback half = dissolve({0.5, 0.5});
  EXPECT_THROW(half.colors(*sphere, {red, blue}), InputError);
  EXPECT_THROW(half.colors(*sphere, {red}), InputError);
  // Also if the only object with weight has no colours, so that the others' would be used.
  EXPECT_THROW(dissolve({1, 0}).colors(*sphere, {nullptr, blue}), InputError);
}

TEST(Dissolve, OfOneObjectAloneHasItsColors) {
  const FloatGrid::Ptr sphere = unitSphere();
  const openvdb::Vec3SGrid::Ptr red = painted(*sphere, {1, 0, 0}), blue = painted(*sphere, {0, 0, 1});
  const openvdb::Vec3SGrid::Ptr colors = dissolve({0, 1}).colors(*sphere, {red, blue});
  ASSERT_EQ(colors->activeVoxelCount(), sphere->activeVoxelCount());
  for (auto color = colors->cbeginValueOn(); color; ++color) EXPECT_EQ(*color, openvdb::Vec3s(0, 0, 1));
}

/// Two constants: the in-between is their weighted mean, exact for weights that are powers of two.
TEST(Dissolve, BlendsValuesWhereTheyAre) {
  std::vector<openvdb::GridBase::ConstPtr> grids;
  for (const float value : {2.f, 6.f}) {
    const FloatGrid::Ptr grid = FloatGrid::create();
    grid->setName("density");
    grid->fill(openvdb::CoordBBox({0, 0, 0}, {7, 7, 7}), value);
    grids.push_back(grid);
  }
  const auto result = openvdb::GridBase::grid<FloatGrid>(dissolve({0.75, 0.25}).carry(grids));
  ASSERT_TRUE(result);
  EXPECT_EQ(result->tree().getValue(openvdb::Coord(3, 4, 5)), 3.f);
}

}  // namespace
}  // namespace slicemorph
