// Maps from the middle space to objects, and back.
#include "engine/match/displacements.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace slicemorph {
namespace {

VectorField sampled(const Lattice& lattice, const std::function<Vec3d(const Vec3d&)>& f) {
  VectorField field(lattice.count());
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x)
        field[lattice.index(x, y, z)] = openvdb::Vec3s(f(lattice.position(x, y, z)));
  return field;
}

/// Points spread over the box of a lattice.
std::vector<Vec3d> pointsIn(const Lattice& lattice, int count) {
  std::mt19937 random(3);
  const Vec3d extent = lattice.spacing * (lattice.size.asVec3d() - Vec3d(1));
  std::vector<Vec3d> points;
  for (int i = 0; i < count; ++i) {
    Vec3d p;
    for (int a = 0; a < 3; ++a)
      p[a] = lattice.origin[a] + std::uniform_real_distribution<>(0, extent[a])(random);
    points.push_back(p);
  }
  return points;
}

/// 1 for an object at its own weights, 0 half way between all objects, and a parabola through
/// both in between.
TEST(Displacements, PathWeightsGoThroughTheMiddle) {
  EXPECT_EQ(pathWeights({1}), (Weights{1}));
  EXPECT_EQ(pathWeights({0, 1, 0}), (Weights{0, 1, 0}));
  for (double w : pathWeights({1 / 3.0, 1 / 3.0, 1 / 3.0})) EXPECT_NEAR(w, 0, 1e-15);
  for (double t : {0.0, 0.2, 0.5, 0.9, 1.0}) {
    const Weights path = pathWeights({1 - t, t});
    EXPECT_NEAR(path[1], t * (2 * t - 1), 1e-15) << t;
    EXPECT_NEAR(path[0], (1 - t) * (1 - 2 * t), 1e-15) << t;
  }
}

/// A smooth map without folds and its inverse: there and back.
TEST(Displacements, MiddlePointsAreFoundBack) {
  const Lattice lattice{{-1, -1, -1}, 0.1, {21, 21, 21}};
  const auto d = [](const Vec3d& s) {
    return Vec3d(0.2 * std::sin(2 * s[1]), 0.15 * std::cos(3 * s[0]), 0.2 * s[2] * s[0]);
  };
  const Displacements map{lattice,
                          {sampled(lattice, [](const Vec3d&) { return Vec3d(0.0); }), sampled(lattice, d)}};
  for (const Vec3d& s : pointsIn({{-0.6, -0.6, -0.6}, 1.2, {2, 2, 2}}, 200)) {
    const Vec3d a = s + map.at(1, s);
    Vec3d found = a, continued = a;
    ASSERT_TRUE(toMiddle(map, 1, a, found));
    ASSERT_TRUE(toMiddleContinued(lattice, map.of[1], a, continued));
    // It stops where the map leads to within a thousandth of a spacing; its least stretch is above 0.4.
    EXPECT_LE((found - s).length(), 1e-3 * lattice.spacing / 0.4);
    EXPECT_LE((continued - s).length(), 1e-3 * lattice.spacing / 0.4);
  }
  // What no middle point is carried to: beyond the lattice there is no displacement.
  Vec3d outside(1.5, 0, 0);
  ASSERT_TRUE(toMiddle(map, 1, {1.5, 0, 0}, outside));
  EXPECT_LE((outside - Vec3d(1.5, 0, 0)).length(), 1e-9);
}

/// A map that carries everything by many spacings: only a guess finds back.
TEST(Displacements, GuessesFarAwayMiddlePoints) {
  const Lattice lattice{{-1, -1, -1}, 0.1, {21, 21, 21}};
  std::mt19937 random(8);
  VectorField field(lattice.count());
  for (auto& v : field)
    v = openvdb::Vec3s(float(std::uniform_real_distribution<>(-0.7, 0.7)(random)),
                       float(std::uniform_real_distribution<>(-0.7, 0.7)(random)), 0.3f);
  const MiddleGuess guess(lattice, field);
  for (const Vec3d& a : pointsIn({{-0.5, -0.5, -0.5}, 1, {2, 2, 2}}, 50)) {
    // The guess looks in the bins around; if the nearest node is less than one spacing away,
    // it is among these.
    double least = 1e30;
    Vec3d nearest(0.0);
    for (int z = 0; z < lattice.size[2]; ++z)
      for (int y = 0; y < lattice.size[1]; ++y)
        for (int x = 0; x < lattice.size[0]; ++x) {
          const Vec3d position = lattice.position(x, y, z) + Vec3d(field[lattice.index(x, y, z)]);
          if (const double off = (position - a).length(); off < least)
            least = off, nearest = lattice.position(x, y, z) + a - position;
        }
    ASSERT_LT(least, lattice.spacing);
    EXPECT_LE((guess.near(a) - nearest).length(), 1e-9);
  }
}

}  // namespace
}  // namespace slicemorph
