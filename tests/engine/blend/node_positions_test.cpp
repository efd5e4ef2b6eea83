#include "engine/blend/node_positions.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <functional>
#include <random>

namespace slicemorph {
namespace {

NodeMap nodesOf(int step, const openvdb::Coord& origin, const openvdb::Coord& size,
                const std::function<Vec3d(const Vec3d&)>& position) {
  NodeMap nodes;
  nodes.step = step, nodes.origin = origin, nodes.size = size, nodes.objects = 2;
  for (int k = 0; k < size[2]; ++k)
    for (int j = 0; j < size[1]; ++j)
      for (int i = 0; i < size[0]; ++i) {
        const Vec3d voxel = step * (origin + openvdb::Coord(i, j, k)).asVec3d();
        nodes.at.push_back(openvdb::Vec3s(0.f));
        nodes.at.push_back(openvdb::Vec3s(position(voxel)));
        nodes.known.push_back(1);
      }
  return nodes;
}

/// The largest error at the voxels of a cell.
double missIn(const NodeMap& nodes, const openvdb::Coord& cell,
              const std::function<Vec3d(const Vec3d&)>& position) {
  std::vector<openvdb::Vec3s> positions(size_t(nodes.step * nodes.step * nodes.step));
  NodePositions(nodes).find(cell[0], cell[1], cell[2], 1, positions);
  double most = 0;
  size_t v = 0;
  for (int x = 0; x < nodes.step; ++x)
    for (int y = 0; y < nodes.step; ++y)
      for (int z = 0; z < nodes.step; ++z)
        most = std::max(
            most, (Vec3d(positions[v++]) - position(nodes.step * cell.asVec3d() + Vec3d(x, y, z))).length());
  return most;
}

const std::function<Vec3d(const Vec3d&)> kParabolas = [](const Vec3d& p) {
  return Vec3d(0.01 * p[0] * p[0] - 0.02 * p[1] * p[2], 0.1 * p[1] + 0.02 * p[2] * p[2],
               0.03 * p[0] * p[1] * p[2] / 8);
};
const std::function<Vec3d(const Vec3d&)> kTrilinear = [](const Vec3d& p) {
  return Vec3d(p[0] - 0.1 * p[1] * p[2], 2 * p[1], 0.01 * p[0] * p[1] * p[2]);
};

/// Splines reproduce parabolas, and trilinear cells at the border functions that are linear along each axis.
TEST(NodePositions, AreSplinedInsideAndLinearAtTheRim) {
  for (int step : {2, 4, 8}) {
    const openvdb::Coord origin(-3, 0, 2), size(5, 5, 5);
    const NodeMap curved = nodesOf(step, origin, size, kParabolas),
                  straight = nodesOf(step, origin, size, kTrilinear);
    const openvdb::Coord inner = origin.offsetBy(1), rim = origin.offsetBy(0, 1, 3);
    EXPECT_LE(missIn(curved, inner, kParabolas), 1e-4) << step;
    EXPECT_LE(missIn(straight, inner, kTrilinear), 1e-4) << step;
    EXPECT_LE(missIn(straight, rim, kTrilinear), 1e-4) << step;
    EXPECT_GT(missIn(curved, rim, kParabolas), 1e-3) << step;
    // With an unknown node around, interpolation is trilinear inside, too, and uses the
    // cell's eight nodes only.
    NodeMap holed = straight;
    const size_t n = holed.index(inner[0] - 1, inner[1], inner[2] + 2);
    holed.known[n] = 0, holed.at[2 * n + 1] = openvdb::Vec3s(1e6f);
    EXPECT_LE(missIn(holed, inner, kTrilinear), 1e-4) << step;
  }
}

TEST(NodePositions, ACellBetweenCrossingSlicesIsTorn) {
  NodeMap nodes =
      nodesOf(4, {0, 0, 0}, {5, 5, 5}, [](const Vec3d& p) { return p[0] > 9 ? p + Vec3d(30, 0, 0) : p; });
  EXPECT_FALSE(NodePositions(nodes).torn(2, 1, 1, 2, 1));  // a straight chart has no slices that cross
  nodes.jump = {100, 16};
  const NodePositions positions(nodes);
  EXPECT_TRUE(positions.torn(2, 1, 1, 2, 1));
  EXPECT_FALSE(positions.torn(1, 1, 1, 2, 1));
  EXPECT_TRUE(positions.torn(0, 0, 0, 4, 1));
  EXPECT_FALSE(positions.torn(2, 1, 1, 2, 0));
  // Next to it splines would reach across the gap: interpolation is trilinear there.
  EXPECT_LE(missIn(nodes, {1, 1, 1}, [](const Vec3d& p) { return p; }), 1e-4);
}

/// All leaves that hold a wanted cell, in order, nodes below zero included.
TEST(NodePositions, LeavesAreThoseOfTheWantedCells) {
  std::mt19937 random(3);
  for (int step : {2, 4, 8}) {
    NodeMap nodes;
    nodes.step = step, nodes.origin = {-7, -2, 1}, nodes.size = {14, 9, 6};
    std::vector<openvdb::Coord> wanted, leaves;
    for (int n = 0; n < 6; ++n)
      wanted.push_back(nodes.origin +
                       openvdb::Coord(int(random() % 13), int(random() % 8), int(random() % 5)));
    for (const openvdb::Coord& c : wanted)
      leaves.push_back({(c[0] * step) & ~7, (c[1] * step) & ~7, (c[2] * step) & ~7});
    std::sort(leaves.begin(), leaves.end(), [](const auto& a, const auto& b) {
      return std::make_tuple(a[2], a[1], a[0]) < std::make_tuple(b[2], b[1], b[0]);
    });
    leaves.erase(std::unique(leaves.begin(), leaves.end()), leaves.end());
    EXPECT_EQ(leavesWith(nodes,
                         [&](int i, int j, int k) {
                           return std::find(wanted.begin(), wanted.end(), openvdb::Coord(i, j, k)) !=
                                  wanted.end();
                         }),
              leaves)
        << step;
  }
}

}  // namespace
}  // namespace slicemorph
