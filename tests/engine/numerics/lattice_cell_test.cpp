#include "engine/numerics/lattice_cell.h"

#include "engine/numerics/tetrahedra.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

using openvdb::Coord;

Lattice lattice() { return {Vec3d(-1, 2, 0.5), 0.25, Coord(7, 9, 8)}; }

/// Trilinear values and weights are single precision: a few units in the last place for values around 10.
constexpr double kRounding = 1e-5;

/// Random points in the lattice's box.
std::vector<Vec3d> pointsIn(const Lattice& l) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> share(0, 1);
  const Vec3d extent = l.position(l.size - Coord(1)) - l.origin;
  std::vector<Vec3d> points;
  for (int i = 0; i < 200; ++i)
    points.push_back(l.origin + Vec3d(share(random), share(random), share(random)) * extent);
  return points;
}

TEST(Lattice, IndexCountsNodesXFastest) {
  const Lattice l = lattice();
  size_t n = 0;
  for (int z = 0; z < l.size[2]; ++z)
    for (int y = 0; y < l.size[1]; ++y)
      for (int x = 0; x < l.size[0]; ++x, ++n) {
        ASSERT_EQ(l.index(x, y, z), n);
        ASSERT_EQ(l.coordOf(n), Coord(x, y, z));
        ASSERT_TRUE(l.holds({x, y, z}));
        for (int c = 0; c < 8; ++c)
          ASSERT_EQ(l.corner(x, y, z, c), l.index(x + c % 2, y + c / 2 % 2, z + c / 4));
      }
  EXPECT_EQ(n, l.count());
  for (int a = 0; a < 3; ++a) {
    Coord low(0, 0, 0), high(0, 0, 0);
    low[a] = -1, high[a] = l.size[a];
    EXPECT_FALSE(l.holds(low));
    EXPECT_FALSE(l.holds(high));
  }
}

TEST(LatticeCell, LinearFunctionsHaveTheirValuesAndGradient) {
  const Lattice l = lattice();
  const Vec3d slope(2, -1, 0.5);
  std::vector<float> values(l.count());
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(3 + slope.dot(l.position(l.coordOf(i))));
  for (const Vec3d& p : pointsIn(l)) {
    const CellPoint point = cellPoint(l, p);
    EXPECT_NEAR(valueAt(l, values, point), 3 + slope.dot(p), kRounding);
    EXPECT_LT((gradientAt(l, values, point) - slope).length(), kRounding / l.spacing);
    double sum = 0;
    for (int c = 0; c < 8; ++c) sum += point.weight(c);
    EXPECT_NEAR(sum, 1, 1e-6);
  }
}

TEST(LatticeCell, PointsOutsideAreMovedOntoTheBorder) {
  const Lattice l = lattice();
  const CellPoint low = cellPoint(l, l.origin - Vec3d(5)), high = cellPoint(l, l.position(l.size) + Vec3d(5));
  EXPECT_EQ(low.cell, 0u);
  EXPECT_EQ(low.weight(0), 1);
  EXPECT_EQ(high.cell, l.index(l.size - Coord(2)));
  EXPECT_EQ(high.weight(7), 1);
}

TEST(Tetrahedra, SixFillACell) {
  Vec3d corners[8];
  for (int c = 0; c < 8; ++c) corners[c] = Vec3d(c & 1, c >> 1 & 1, c >> 2);
  for (const auto& t : kKuhnTetrahedra) EXPECT_EQ(parallelepipedVolume(corners, t), 1);
  // Every point is in exactly one tetrahedron, on the inner side of its four faces.
  for (const Vec3d& p : pointsIn({Vec3d(0.0), 1, Coord(2)})) {
    int holders = 0;
    for (const auto& t : kKuhnTetrahedra) {
      bool holds = true;
      for (int face = 0; face < 4; ++face) {
        Vec3d with[8];
        std::copy(corners, corners + 8, with);
        with[t[face]] = p;
        holds = holds && parallelepipedVolume(with, t) > 0;
      }
      holders += holds;
    }
    EXPECT_EQ(holders, 1);
  }
}

}  // namespace
}  // namespace slicemorph
