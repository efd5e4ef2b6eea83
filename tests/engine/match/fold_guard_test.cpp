// Volumes of tetrahedra by determinants, and maps that fold at known positions.
#include "engine/match/fold_guard.h"

#include "engine/numerics/tetrahedra.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace slicemorph {
namespace {

const Lattice kGuardLattice{{0.3, -2, 1}, 0.2, {12, 11, 10}};

Displacements zeroMap(size_t objects) {
  return {kGuardLattice,
          std::vector<VectorField>(objects, VectorField(kGuardLattice.count(), openvdb::Vec3s(0.f)))};
}

Displacements randomMap(size_t objects, float size, unsigned seed) {
  std::mt19937 random(seed);
  Displacements map = zeroMap(objects);
  for (VectorField& field : map.of)
    for (openvdb::Vec3s& v : field)
      for (int a = 0; a < 3; ++a) v[a] = std::uniform_real_distribution<float>(-size, size)(random);
  return map;
}

/// Least determinant over all tetrahedra whose corners lie along one order of the axes, after s + D(s) where
/// D = sum_k share[k] of[k]: 1 where nothing moves.
double leastDeterminant(const Displacements& map, const Weights& share) {
  const auto at = [&](const openvdb::Coord& c) {
    Vec3d p = kGuardLattice.position(c[0], c[1], c[2]);
    for (size_t k = 0; k < share.size(); ++k)
      p += share[k] * Vec3d(map.of[k][kGuardLattice.index(c[0], c[1], c[2])]);
    return p / kGuardLattice.spacing;
  };
  double least = 1e30;
  for (int z = 0; z + 1 < kGuardLattice.size[2]; ++z)
    for (int y = 0; y + 1 < kGuardLattice.size[1]; ++y)
      for (int x = 0; x + 1 < kGuardLattice.size[0]; ++x) {
        int order[3] = {0, 1, 2};
        do {
          openvdb::Coord c(x, y, z);
          Mat3d m;
          for (int step = 0; step < 3; ++step) {
            const Vec3d from = at(c);
            ++c[order[step]];
            m.setCol(order[step], at(c) - from);
          }
          least = std::min(least, m.det());
        } while (std::next_permutation(order, order + 3));
      }
  return least;
}

Weights alone(size_t object, size_t objects) {
  Weights w(objects, 0);
  w[object] = 1;
  return w;
}

TEST(FoldGuard, NothingMovedIsNotSqueezed) { EXPECT_NEAR(leastRatio(zeroMap(2)), 1, 1e-6); }

TEST(FoldGuard, AffineMapsSqueezeByTheirDeterminant) {
  const Mat3d m(0.1, 0.4, -0.2, 0.3, -0.3, 0.0, 0.2, 0.1, -0.4);
  Displacements map = zeroMap(2);
  for (int z = 0; z < kGuardLattice.size[2]; ++z)
    for (int y = 0; y < kGuardLattice.size[1]; ++y)
      for (int x = 0; x < kGuardLattice.size[0]; ++x)
        map.of[1][kGuardLattice.index(x, y, z)] = openvdb::Vec3s(m * kGuardLattice.position(x, y, z));
  EXPECT_NEAR(leastRatio(map), (Mat3d::identity() + m).det(), 1e-5);
}

TEST(FoldGuard, TheLeastRatioIsThatOfAllTetrahedra) {
  for (unsigned seed = 0; seed < 5; ++seed) {
    const Displacements map = randomMap(2, 0.02f + 0.03f * float(seed), seed);
    EXPECT_NEAR(leastRatio(map),
                std::min(leastDeterminant(map, alone(0, 2)), leastDeterminant(map, alone(1, 2))), 1e-5);
  }
}

/// The corners of the six tetrahedra fill the cell and are the same across opposite faces.
TEST(FoldGuard, TetrahedraFillTheCell) {
  double volume = 0;
  for (const auto& t : kKuhnTetrahedra) {
    Mat3d edges;
    for (int i = 0; i < 3; ++i) {
      const int a = t[i + 1], b = t[0];
      edges.setCol(i, Vec3d((a & 1) - (b & 1), (a >> 1 & 1) - (b >> 1 & 1), (a >> 2) - (b >> 2)));
    }
    EXPECT_NEAR(edges.det(), 1, 1e-15);
    volume += edges.det() / 6;
    for (int bit : {1, 2, 4}) {
      const bool low = std::count_if(t, t + 4, [&](int c) { return !(c & bit); }) == 3;
      if (!low) continue;
      // A face at the low side of an axis is met, moved to the high side, by another tetrahedron.
      int met = 0;
      for (const auto& u : kKuhnTetrahedra)
        met +=
            std::all_of(t, t + 4, [&](int c) { return (c & bit) || std::find(u, u + 4, c | bit) != u + 4; });
      EXPECT_EQ(met, 1);
    }
  }
  EXPECT_NEAR(volume, 1, 1e-15);
}

TEST(FoldGuard, MapsWithoutFoldsStayAsTheyAre) {
  Displacements map = randomMap(2, 0.02f, 3);
  ASSERT_GT(leastRatio(map), 0.3);
  const Displacements before = map;
  EXPECT_EQ(removeFolds(map), 0);
  EXPECT_EQ(map.of, before.of);
}

/// Where an in-between of two objects has its nodes.
Weights pathAt(double t) { return pathWeights({1 - t, t}); }

/// One node drawn past its neighbour folds the map to its object; afterwards neither that nor the
/// other, nor those half way from the middle to them, squeeze anything below the bound, and what is
/// far away is untouched.
TEST(FoldGuard, AKnownFoldIsSmoothedAway) {
  for (double floor : {0.05, 0.12, 0.3}) {
    Displacements map = zeroMap(2);
    const size_t node = kGuardLattice.index(3, 4, 4);
    map.of[0][node] = openvdb::Vec3s(float(1.6 * kGuardLattice.spacing), 0, 0);
    map.of[1][node] = -map.of[0][node];
    // The neighbour along x, one spacing on, is overtaken by 0.6 of it.
    ASSERT_NEAR(leastRatio(map), -0.6, 1e-5);
    map.of[0][kGuardLattice.index(11, 10, 9)] = openvdb::Vec3s(0.01f);
    EXPECT_GT(removeFolds(map, floor), 0);
    for (double t : {0.0, 0.25, 0.75, 1.0}) EXPECT_GE(leastDeterminant(map, pathAt(t)), floor - 1e-5) << t;
    EXPECT_EQ(map.of[0][kGuardLattice.index(11, 10, 9)], openvdb::Vec3s(0.01f));
  }
}

/// What is squeezed to just below the bound is smoothed until it is not, what is just above stays as it is.
TEST(FoldGuard, TheBoundIsMet) {
  const double floor = 0.2;
  for (double ratio : {0.8 * floor, 1.02 * floor}) {
    Displacements map = zeroMap(1);
    // One node drawn towards its neighbour along x leaves this share of the cells between.
    map.of[0][kGuardLattice.index(5, 5, 5)] =
        openvdb::Vec3s(float((1 - ratio) * kGuardLattice.spacing), 0, 0);
    ASSERT_NEAR(leastRatio(map), ratio, 1e-5);
    EXPECT_EQ(removeFolds(map, floor) > 0, ratio < floor);
    EXPECT_GE(leastRatio(map), floor - 1e-5);
  }
}

/// What smoothing alone may not cure.
TEST(FoldGuard, WildMapsBecomeOneToOne) {
  Displacements map = randomMap(3, float(5 * kGuardLattice.spacing), 9);
  ASSERT_LT(leastRatio(map), -1);
  removeFolds(map);
  for (size_t k = 0; k < 3; ++k) {
    EXPECT_GE(leastDeterminant(map, alone(k, 3)), 0.12 - 1e-5) << k;
    Weights half(3, 1 / 6.0);
    half[k] += 0.5;
    EXPECT_GE(leastDeterminant(map, pathWeights(half)), 0.12 - 1e-5) << k;
  }
}

}  // namespace
}  // namespace slicemorph
