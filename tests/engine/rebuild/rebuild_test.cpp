// Level sets rebuilt through known node maps: balls that are shifted and scaled.
#include "engine/rebuild/rebuild.h"
#include "tests/support/fields.h"
#include "tests/support/same_values.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kRebuiltVoxel = 0.05;

/// Nodes that map p to size[k] p + offset[k] on object k, on voxels of kRebuiltVoxel.
NodeMap nodesOf(const std::vector<double>& size, const std::vector<Vec3d>& offset, const Fields& fields) {
  NodeMap nodes;
  nodes.step = 4, nodes.objects = size.size(), nodes.origin = openvdb::Coord(-9),
  nodes.size = openvdb::Coord(19);
  nodes.known.assign(19 * 19 * 19, 1);
  nodes.at.resize(nodes.known.size() * size.size());
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-9), openvdb::Coord(9)).begin(); c; ++c)
    for (size_t k = 0; k < size.size(); ++k)
      nodes.at[nodes.index((*c)[0], (*c)[1], (*c)[2]) * size.size() + k] =
          fields[k]->relative(size[k] * (4 * kRebuiltVoxel * (*c).asVec3d()) + offset[k]);
  return nodes;
}

double missOf(const FloatGrid& grid, double radius) {
  double most = 0;
  size_t count = 0;
  for (auto it = grid.cbeginValueOn(); it; ++it, ++count)
    most =
        std::max(most, std::abs(*it - (grid.indexToWorld(it.getCoord()).length() - radius)) / kRebuiltVoxel);
  // All voxels of the band, which is 6 voxels thick.
  EXPECT_NEAR(double(count), 6 * 4 * M_PI * radius * radius / (kRebuiltVoxel * kRebuiltVoxel),
              0.02 * double(count));
  EXPECT_LT(grid.tree().getValue({0, 0, 0}), 0);
  return most;
}

Fields ballsOf(double first, double second, const Vec3d& to) {
  return {
      shapes::fieldOf(shapes::sphere({0, 0, 0}, first), shapes::cube({0, 0, 0}, first + 0.3), kRebuiltVoxel),
      shapes::fieldOf(shapes::sphere(to, second), shapes::cube(to, second + 0.3), kRebuiltVoxel)};
}

/// Error bound in voxels. Trilinear interpolation of a distance with curvature 2 / r loses 2 / (8 r), once
/// when it is sampled and once when it is redistanced (r is 16 voxels or more). Beyond 1.8 voxels of an
/// object's surface, distances are those to the nearest of surface points a voxel apart: 0.5 / (2 d) at
/// distance d.
constexpr double kLost = 2 * 2 / (8 * 16.0) + 0.5 / (2 * 1.8);

/// Objects that the map aligns exactly give the same ball.
TEST(Rebuild, LikeObjectsGiveTheSame) {
  const Vec3d to(3, -1, 2);
  const Fields fields = ballsOf(1, 1, to);
  const DistanceBlend blend{LocalWeights({0.4, 0.6}, nullptr), {1, 1}, 1};
  const auto transform = openvdb::math::Transform::createLinearTransform(kRebuiltVoxel);
  const NodeMap nodes = nodesOf({1, 1}, {{0, 0, 0}, to}, fields);
  const FloatGrid::Ptr grid = rebuildLevelSet(nodes, fields, blend, *transform);
  EXPECT_LE(missOf(*grid, 1), kLost);
  EXPECT_EQ(grid->getName(), "surface");
  EXPECT_EQ(grid->getGridClass(), openvdb::GRID_LEVEL_SET);
  withThreads(1, [&] { EXPECT_TRUE(sameValues(*grid, *rebuildLevelSet(nodes, fields, blend, *transform))); });
}

/// Distances count in units of each object's own size: balls of 0.8 and 1.6 that the map scales to one size.
TEST(Rebuild, DistancesCountInSizes) {
  const Fields fields = ballsOf(0.8, 1.6, {0, 0, 0});
  const auto transform = openvdb::math::Transform::createLinearTransform(kRebuiltVoxel);
  const NodeMap nodes = nodesOf({0.8 / 1.2, 1.6 / 1.2}, {{0, 0, 0}, {0, 0, 0}}, fields);
  const DistanceBlend blend{LocalWeights({0.5, 0.5}, nullptr), {0.8, 1.6}, 1.2};
  EXPECT_LE(missOf(*rebuildLevelSet(nodes, fields, blend, *transform), 1.2), kLost);
}

/// Where the map leaves a difference, distances are blended: concentric balls of 0.9 and 1.1.
TEST(Rebuild, WhatIsNotMatchedIsBlended) {
  const Fields fields = ballsOf(0.9, 1.1, {0, 0, 0});
  const auto transform = openvdb::math::Transform::createLinearTransform(kRebuiltVoxel);
  const NodeMap nodes = nodesOf({1, 1}, {{0, 0, 0}, {0, 0, 0}}, fields);
  for (double t : {0.25, 0.5}) {
    const DistanceBlend blend{LocalWeights({1 - t, t}, nullptr), {1, 1}, 1};
    EXPECT_LE(missOf(*rebuildLevelSet(nodes, fields, blend, *transform), 0.9 + 0.2 * t), kLost) << t;
  }
}

/// The distances of an object of weight 0 are not read.
TEST(Rebuild, ObjectsThatDoNotCountAreLeftOut) {
  Fields fields = ballsOf(1, 1, {0, 0, 0});
  const NodeMap nodes = nodesOf({1, 1}, {{0, 0, 0}, {0, 0, 0}}, fields);
  fields[1] = nullptr;
  const DistanceBlend blend{LocalWeights({1, 0}, nullptr), {1, 1}, 1};
  const auto transform = openvdb::math::Transform::createLinearTransform(kRebuiltVoxel);
  EXPECT_LE(missOf(*rebuildLevelSet(nodes, fields, blend, *transform), 1), kLost);
}

}  // namespace
}  // namespace slicemorph
