#include "engine/numerics/lattice.h"

#include "engine/numerics/lattice_cell.h"
#include "engine/numerics/lattice_field.h"
#include "engine/numerics/tetrahedra.h"

#include <gtest/gtest.h>

#include <random>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::Vec3s;

Lattice lattice() { return {Vec3d(-1, 2, 0.5), 0.25, Coord(7, 9, 8)}; }

Vec3d linear(const Vec3d& p) {
  return Vec3d(1, -2, 0.5) + Vec3d(2 * p[0] - p[1], p[2] + 0.25 * p[0], p[1] - 3 * p[2]);
}

/// Tri-linear values and weights are single precision: a few units in the last place of values around 10.
constexpr double kRounding = 1e-5;

template <typename F>
VectorField fieldOf(const Lattice& l, const F& f) {
  VectorField field(l.count());
  for (size_t i = 0; i < field.size(); ++i) field[i] = Vec3s(f(l.position(l.coordOf(i))));
  return field;
}

/// Points of the lattice's box widened by `margin` on all sides.
std::vector<Vec3d> pointsIn(const Lattice& l, double margin) {
  std::mt19937 random(17);
  std::uniform_real_distribution<double> share(0, 1);
  const Vec3d low = l.origin - Vec3d(margin), high = l.position(l.size - Coord(1)) + Vec3d(margin);
  std::vector<Vec3d> points;
  for (int i = 0; i < 200; ++i)
    points.push_back(low + Vec3d(share(random), share(random), share(random)) * (high - low));
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
      }
  EXPECT_EQ(n, l.count());
  for (int a = 0; a < 3; ++a) {
    Coord low(0, 0, 0), high(0, 0, 0);
    low[a] = -1, high[a] = l.size[a];
    EXPECT_FALSE(l.holds(low));
    EXPECT_FALSE(l.holds(high));
  }
}

TEST(Lattice, OverABoxCoversItAndIsCentred) {
  for (double spacing : {0.1, 0.3, 5.0}) {
    const openvdb::BBoxd box(Vec3d(-1, 0, 2), Vec3d(1.5, 0.2, 4));
    const Lattice l = Lattice::over(box, spacing);
    const Vec3d last = l.position(l.size - Coord(1));
    for (int a = 0; a < 3; ++a) {
      EXPECT_LE(l.origin[a], box.min()[a] + 1e-9);
      EXPECT_GE(last[a], box.max()[a] - 1e-9);
      EXPECT_NEAR(0.5 * (l.origin[a] + last[a]), box.getCenter()[a], 1e-12);
      EXPECT_TRUE(l.size[a] == 2 || last[a] - l.origin[a] < box.extents()[a] + spacing);
    }
  }
}

TEST(LatticeField, LinearFieldsAreSampledAsTheyAre) {
  const Lattice l = lattice();
  const VectorField field = fieldOf(l, linear);
  for (const Vec3d& p : pointsIn(l, 0)) {
    EXPECT_LT((sampleField(l, field, p) - linear(p)).length(), kRounding);
    EXPECT_LT((sampleContinued(l, field, p) - linear(p)).length(), kRounding);
  }
}

TEST(LatticeField, BeyondTheLatticeIsNothingOrTheNearestPoint) {
  const Lattice l = lattice();
  const VectorField field = fieldOf(l, linear);
  const Vec3d low = l.origin, high = l.position(l.size - Coord(1));
  int beyond = 0;
  for (const Vec3d& p : pointsIn(l, 2)) {
    const Vec3d nearest = openvdb::math::minComponent(openvdb::math::maxComponent(p, low), high);
    EXPECT_LT((sampleContinued(l, field, p) - linear(nearest)).length(), kRounding);
    if (nearest == p) continue;
    ++beyond;
    EXPECT_EQ(sampleField(l, field, p), Vec3d(0.0));
  }
  EXPECT_GT(beyond, 50);
}

/// Catmull-Rom splines have the values of any quadratic polynomial (Keys 1981), but next to the border, beyond which
/// all is zero.
TEST(LatticeField, ResamplingKeepsQuadraticFields) {
  const Lattice from{Vec3d(-1, -1, -1), 0.25, Coord(9, 10, 11)};
  const auto quadratic = [](const Vec3d& p) {
    return Vec3d(p[0] * p[0] - p[1], p[0] * p[1] + p[2], 1 - p[2] * p[2]);
  };
  const VectorField field = fieldOf(from, quadratic);
  const Vec3d inner = from.position(1, 1, 1), end = from.position(from.size - Coord(2));
  const Lattice to = Lattice::over(openvdb::BBoxd(inner + Vec3d(0.01), end - Vec3d(0.01)), 0.11);
  const VectorField found = resampleField(from, field, to);
  int compared = 0;
  for (size_t i = 0; i < found.size(); ++i) {
    const Vec3d p = to.position(to.coordOf(i));
    if (!openvdb::BBoxd(inner, end).isInside(p)) continue;
    ++compared;
    EXPECT_LT((Vec3d(found[i]) - quadratic(p)).length(), kRounding);
  }
  EXPECT_GT(compared, 500);
  // On the lattice's own nodes nothing changes, not even at its border.
  const VectorField same = resampleField(from, field, from);
  for (size_t i = 0; i < same.size(); ++i) EXPECT_LT((same[i] - field[i]).length(), 1e-6f);
}

TEST(LatticeCell, LinearFunctionsHaveTheirValuesAndGradient) {
  const Lattice l = lattice();
  const Vec3d slope(2, -1, 0.5);
  std::vector<float> values(l.count());
  for (size_t i = 0; i < values.size(); ++i) values[i] = float(3 + slope.dot(l.position(l.coordOf(i))));
  for (const Vec3d& p : pointsIn(l, 0)) {
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
  // Every point is in exactly one: on the inner side of all four faces.
  for (const Vec3d& p : pointsIn({Vec3d(0.0), 1, Coord(2)}, 0)) {
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
