// Functions that are distances up to a factor become distances again, with their signs kept.
#include "engine/rebuild/redistance.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

constexpr float kDistanceVoxel = 0.1f;

/// `function` on all leaves within `reach` voxels of the shape's surface, in a box of +-`leaves` leaves about
/// the world's origin.
SparseValues valuesOf(const shapes::Distance& shape, const shapes::Distance& function, int leaves = 4) {
  std::vector<openvdb::Coord> origins;
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-leaves), openvdb::Coord(leaves - 1)).begin(); c; ++c) {
    const openvdb::Coord origin((*c)[0] * 8, (*c)[1] * 8, (*c)[2] * 8);
    if (std::abs(shape(double(kDistanceVoxel) * (origin.asVec3d() + Vec3d(3.5)))) <
        double(kDistanceVoxel) * 14)
      origins.push_back(origin);
  }
  SparseValues values(origins, kDistanceVoxel);
  for (size_t i = 0; i < origins.size(); ++i)
    for (int n = 0; n < 512; ++n)
      values.leaf(i)[n] =
          float(function(double(kDistanceVoxel) * origins[i].offsetBy(n / 64, n / 8 % 8, n % 8).asVec3d()));
  return values;
}

FloatGrid::Ptr made(const SparseValues& values) {
  return redistance(values, *openvdb::math::Transform::createLinearTransform(double(kDistanceVoxel)));
}

bool everywhere(const Vec3d&) { return true; }

/// Expects the shape's distances within `tolerance` voxels where `counts` says so, all voxels nearer than
/// `whole` active, and the shape's sign everywhere.
void expectDistance(const FloatGrid& grid, const shapes::Distance& shape, double tolerance, double whole,
                    bool (*counts)(const Vec3d&) = everywhere) {
  EXPECT_EQ(grid.getGridClass(), openvdb::GRID_LEVEL_SET);
  EXPECT_FLOAT_EQ(grid.background(), 3 * kDistanceVoxel);
  double most = 0;
  for (auto it = grid.cbeginValueOn(); it; ++it) {
    const Vec3d p = grid.indexToWorld(it.getCoord());
    EXPECT_LT(std::abs(*it), 3 * kDistanceVoxel);
    if (counts(p)) most = std::max(most, std::abs(double(*it) - shape(p)) / double(kDistanceVoxel));
  }
  EXPECT_LE(most, tolerance);
  size_t missing = 0, wrongSide = 0;
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-30), openvdb::Coord(30)).begin(); c; ++c) {
    const Vec3d p = grid.indexToWorld(*c);
    const double d = shape(p) / double(kDistanceVoxel);
    wrongSide += std::abs(d) > 1e-3 && (grid.tree().getValue(*c) < 0) != (d < 0);
    missing += counts(p) && std::abs(d) < whole && !grid.tree().isValueOn(*c);
  }
  EXPECT_EQ(missing, 0u);
  EXPECT_EQ(wrongSide, 0u);
}

/// A plane with any gradient: both steps are exact.
TEST(Redistance, PlanesAreExact) {
  const Vec3d normal = Vec3d(1, 2, -0.5).unit();
  const shapes::Distance plane = [=](const Vec3d& p) { return p.dot(normal) - 0.04; };
  for (double factor : {0.7, 1.0, 1.3}) {
    const FloatGrid::Ptr grid = made(valuesOf(plane, [&](const Vec3d& p) { return factor * plane(p); }));
    // At the box's sides, where the values end, neighbours are unknown.
    const auto within = [](const Vec3d& p) {
      return std::max({std::abs(p[0]), std::abs(p[1]), std::abs(p[2])}) < 2.3;
    };
    double most = 0;
    for (auto it = grid->cbeginValueOn(); it; ++it) {
      const Vec3d p = grid->indexToWorld(it.getCoord());
      if (within(p)) most = std::max(most, std::abs(double(*it) - plane(p)) / double(kDistanceVoxel));
    }
    EXPECT_LE(most, 1e-3) << factor;
  }
}

/// A sphere of radius 20 voxels: central differences and trilinear values lose a voxel's square over 8 radii
/// in each of three directions, twice.
constexpr double kOfASphere = 2 * 3 / (8 * 20.0 - 3);

TEST(Redistance, SpheresOfAnySlope) {
  const shapes::Distance sphere = shapes::sphere({0.03, -0.02, 0.05}, 2);
  for (double factor : {0.7, 1.0, 1.3})
    expectDistance(*made(valuesOf(sphere, [&](const Vec3d& p) { return factor * sphere(p); })), sphere,
                   kOfASphere, kHalfWidth - 2 * kOfASphere);
}

/// A factor k that changes by up to k' = 0.2 / 4 per voxel. The first step is off by d^2 k' / k: 0.56 at
/// three voxels and the smallest factor; voxels that it places beyond the band are left out. After the second
/// step the relative change of the gradient along the way remains of that, 2 d k' / k = 0.38, and the
/// sphere's own error.
TEST(Redistance, FactorsMayChange) {
  const shapes::Distance sphere = shapes::sphere({0, 0, 0}, 2);
  const auto warped = [&](const Vec3d& p) { return sphere(p) * (1 + 0.2 * std::sin(p[0] / 0.4)); };
  expectDistance(*made(valuesOf(sphere, warped)), sphere, 0.56 * 0.38 + kOfASphere, kHalfWidth - 0.56);
}

bool awayFromEdges(const Vec3d& p) { return std::abs(p[1]) < 0.7 && std::abs(p[2]) < 0.5; }

/// In front of and behind a box's faces distances are exact. Inside, along its edges, the differences belong
/// to neither face and the distances come out longer; signs are right everywhere.
TEST(Redistance, BoxesKeepTheirFaces) {
  const shapes::Distance box = shapes::box({1.5, 1.23, 0.97}, 0.001);
  expectDistance(*made(valuesOf(box, box)), box, 1e-2, kHalfWidth - 1e-2, awayFromEdges);
}

/// A gap one voxel wide stays open: signs are kept whatever the gradients are.
TEST(Redistance, ThinGapsStayOpen) {
  const shapes::Distance sheets = [](const Vec3d& p) { return 0.05 - std::abs(std::abs(p[0]) - 0.1); };
  const FloatGrid::Ptr grid = made(valuesOf(shapes::sphere({0, 0, 0}, 1), sheets));
  for (auto it = grid->cbeginValueOn(); it; ++it) {
    const double d = sheets(grid->indexToWorld(it.getCoord()));
    if (std::abs(d) > 1e-6) {
      EXPECT_EQ(*it < 0, d < 0) << it.getCoord();
    }
  }
}

TEST(Redistance, NothingIsAnEmptyGrid) {
  const FloatGrid::Ptr grid = made(SparseValues({}, kDistanceVoxel));
  EXPECT_EQ(grid->activeVoxelCount(), 0u);
  EXPECT_EQ(grid->getName(), "surface");
}

TEST(Redistance, LeavesAreFoundByTheirOrigin) {
  SparseValues values({{0, 0, 0}, {-8, 16, 0}}, kDistanceVoxel);
  EXPECT_EQ(values.find({-8, 16, 0}), values.leaf(1));
  EXPECT_EQ(values.find({8, 0, 0}), nullptr);
  EXPECT_EQ(values.leaf(0)[17], SparseValues::kUnknown);
}

}  // namespace
}  // namespace slicemorph
