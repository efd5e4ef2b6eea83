#include "engine/rebuild/add_vectors.h"
#include "slicemorph/errors.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

Vec3d field(const Vec3d& p) { return {1 + p[0] - 2 * p[1], 0.5 * p[2], 3 - p[0] + p[2]}; }

/// A linear vector field on voxels 0 .. 20 along each axis; staggered components are located on the face
/// before their voxel.
template <typename GridType>
typename GridType::Ptr linearVectors(double voxel, const Vec3d& offset, bool staggered) {
  auto grid = GridType::create();
  auto transform = openvdb::math::Transform::createLinearTransform(voxel);
  transform->postTranslate(offset);
  grid->setTransform(transform);
  if (staggered) grid->setGridClass(openvdb::GRID_STAGGERED);
  for (auto c = openvdb::CoordBBox({0, 0, 0}, {20, 20, 20}).begin(); c; ++c) {
    typename GridType::ValueType value;
    for (int a = 0; a < 3; ++a) {
      Vec3d at = (*c).asVec3d();
      if (staggered) at[a] -= 0.5;
      value[a] = typename GridType::ValueType::value_type(field(grid->indexToWorld(at))[a]);
    }
    grid->tree().setValue(*c, value);
  }
  return grid;
}

/// The voxels differ from those of the added grid; trilinear sampling of a linear field is exact.
template <typename GridType>
void expectAdded(bool staggered) {
  auto to = openvdb::Vec3SGrid::create();
  to->setTransform(openvdb::math::Transform::createLinearTransform(0.3));
  for (auto c = openvdb::CoordBBox({1, 1, 1}, {4, 4, 4}).begin(); c; ++c)
    to->tree().setValue(*c, openvdb::Vec3s(1, 2, 3));
  to->tree().setValueOff({2, 2, 2}, openvdb::Vec3s(9.f));
  addVectors(*to, *linearVectors<GridType>(0.1, {-0.05, -0.2, 0.07}, staggered), -2);
  for (auto it = to->cbeginValueOn(); it; ++it)
    ASSERT_LE((Vec3d(*it) - (Vec3d(1, 2, 3) - 2.0 * field(to->indexToWorld(it.getCoord())))).length(), 1e-4)
        << it.getCoord();
  EXPECT_EQ(to->tree().getValue({2, 2, 2}), openvdb::Vec3s(9.f));  // inactive, hence unchanged
}

TEST(AddVectors, AreSampledWhereTheyAreAdded) {
  expectAdded<openvdb::Vec3SGrid>(false);
  expectAdded<openvdb::Vec3DGrid>(false);
  expectAdded<openvdb::Vec3SGrid>(true);
}

TEST(AddVectors, OtherTypesAreRefused) {
  auto to = openvdb::Vec3SGrid::create();
  const FloatGrid::Ptr density = FloatGrid::create();
  density->setName("density");
  try {
    addVectors(*to, *density, 1);
    FAIL();
  } catch (const InputError& e) {
    EXPECT_NE(std::string(e.what()).find("density"), std::string::npos);
  }
}

}  // namespace
}  // namespace slicemorph
