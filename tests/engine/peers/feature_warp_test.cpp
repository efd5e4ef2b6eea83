#include "engine/peers/feature_warp.h"

#include "slicemorph/errors.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kWarpVoxel = 0.5;

Object warpObject(const shapes::Distance& distance, const Vec3d& centre = Vec3d(0.0)) {
  return {"object", shapes::levelSet(distance, shapes::cube(centre, 14), kWarpVoxel)};
}

Feature pointAt(const std::vector<Vec3d>& places) {
  Feature feature;
  feature.name = "point";
  for (const Vec3d& p : places) feature.positions.push_back({p});
  return feature;
}

double farthestFromWarped(const FloatGrid& frame, const shapes::Distance& shape) {
  double farthest = 0;
  for (const Vec3d& p : surfacePoints(frame)) farthest = std::max(farthest, std::abs(shape(p)));
  return farthest;
}

/// A point feature alone is a translation: balls of radii 4 and 8 there are distances |q| - 4 and |q| - 8 of one point q,
/// whose blend is a ball of the radius between, without any error but the voxels' (h^2 / 8 / radius each).
TEST(FeatureWarp, MovesBallsByAPoint) {
  const Vec3d a(-6, 1, 0), b(5, -2, 3);
  const FeatureWarp warp({warpObject(shapes::sphere(a, 4), a), warpObject(shapes::sphere(b, 8), b)},
                         kWarpVoxel, {pointAt({a, b})});
  for (const double t : {0.0, 0.5, 1.0}) {
    const FloatGrid::Ptr frame = warp.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    EXPECT_LT(farthestFromWarped(*frame, shapes::sphere((1 - t) * a + t * b, 4 + 4 * t)), 0.1 * kWarpVoxel)
        << t;
  }
}

/// A line along a bar turns it whole about its middle, by the shortest way. The bar's corners are parts of spheres of
/// radius 2, where linear values are off by h^2 / 8 times the sum of the curvatures, 1: when the bar is sampled between its
/// voxels, when distances are swept from where edges of the result's voxels are crossed, and when its surface is meshed.
TEST(FeatureWarp, TurnsABarByALine) {
  const auto bar = shapes::box({10, 4, 3}, 2);
  const auto turn = [](double degrees) {
    return rotationFromVector({0, 0, degrees * openvdb::math::pi<double>() / 180});
  };
  Feature line{"line", Feature::Kind::kLine, {{{-10, 0, 0}, {10, 0, 0}}, {}}};
  for (const Vec3d& p : line.positions[0]) line.positions[1].push_back(turn(90) * p);
  const FeatureWarp warp({warpObject(bar), warpObject(shapes::placed(bar, turn(90), Vec3d(0.0)))}, kWarpVoxel,
                         {line});
  for (const double t : {0.0, 1.0 / 3, 0.5})
    EXPECT_LT(farthestFromWarped(*warp.frame({1 - t, t}), shapes::placed(bar, turn(90 * t), Vec3d(0.0))),
              3 * kWarpVoxel * kWarpVoxel / 8)
        << t;
}

/// A disk scales all directions by its radius: balls of radii 4 and 8 with disks of these radii.
TEST(FeatureWarp, ScalesByADisk) {
  Feature disk{"disk", Feature::Kind::kDisk, {{{0, 0, 0}}, {{0, 0, 0}}}, {{0, 0, 1}, {0, 2, 2}}, {4, 8}};
  const FeatureWarp warp({warpObject(shapes::sphere({0, 0, 0}, 4)), warpObject(shapes::sphere({0, 0, 0}, 8))},
                         kWarpVoxel, {disk});
  EXPECT_LT(farthestFromWarped(*warp.frame({0.5, 0.5}), shapes::sphere(Vec3d(0.0), 6)), 0.1 * kWarpVoxel);
  // Half way the normal is turned by 22.5 degrees about x, the radius is 6. On the first object it is the one along z.
  const double angle = 22.5 * openvdb::math::pi<double>() / 180;
  const Vec3d tip = 6 * Vec3d(0, std::sin(angle), std::cos(angle));
  EXPECT_LT((warp.onObject(tip, {0.5, 0.5}, 0) - Vec3d(0, 0, 4)).length(), 1e-9);
  EXPECT_LT((warp.onObject(tip, {0.5, 0.5}, 1) - Vec3d(0, std::sqrt(32), std::sqrt(32))).length(), 1e-9);
}

/// Two points that move by 2 along x and by 6 along y: half way they are 1 and 3 on. In between, at distances 4 and 6 from
/// them, a point of the in-between is moved back by their means with weights 1/16 and 1/36.
TEST(FeatureWarp, WeighsFeaturesByTheSquareOfTheirDistance) {
  const Object ball = warpObject(shapes::sphere({0, 0, 0}, 8));
  FeatureWarpOptions options;
  options.nearness = 1e-9;
  const Feature first = pointAt({{-5, 0, 0}, {-3, 0, 0}});
  const Feature second = pointAt({{6, -3, 0}, {6, 3, 0}});
  const FeatureWarp warp({ball, ball}, kWarpVoxel, {first, second}, options);
  const double a = 1.0 / 16, b = 1.0 / 36;
  const Vec3d expected = (a * Vec3d(-1, 0, 0) + b * Vec3d(0, -3, 0)) / (a + b);
  EXPECT_LT((warp.onObject({0, 0, 0}, {0.5, 0.5}, 0) - expected).length(), 1e-6);
  EXPECT_LT((warp.onObject({-4, 0, 0}, {0.5, 0.5}, 0) - Vec3d(-5, 0, 0)).length(), 1e-6);
  // A line is as far away as its nearest point: from (0, 4, 0), 4 from the one along x and 6 from the one at x = 6.
  const Feature line{"line", Feature::Kind::kLine, {{{-9, 0, 0}, {3, 0, 0}}, {{-7, 0, 0}, {5, 0, 0}}}};
  const Feature far = pointAt({{6, 1, 0}, {6, 7, 0}});
  const FeatureWarp mixed({ball, ball}, kWarpVoxel, {line, far}, options);
  EXPECT_LT((mixed.onObject({0, 4, 0}, {0.5, 0.5}, 0) - Vec3d(0, 4, 0) - expected).length(), 1e-6);
}

TEST(FeatureWarp, RefusesWhatItCannotTake) {
  const std::vector<Object> balls(2, warpObject(shapes::sphere({0, 0, 0}, 6)));
  const auto refusalOf = [&](const std::vector<Feature>& features, double voxelSize = kWarpVoxel) {
    return refusal([&] { FeatureWarp(balls, voxelSize, features).frame({0.5, 0.5}); });
  };
  EXPECT_NE(refusalOf({}).find("needs features"), std::string::npos);
  EXPECT_NE(
      refusalOf({{"back", Feature::Kind::kLine, {{{0, 0, 0}, {1, 0, 0}}, {{0, 0, 0}}}}}).find("'back' has 2"),
      std::string::npos);
  EXPECT_NE(refusalOf({pointAt({{0, 0, 0}})}).find("there are 2"), std::string::npos);
  EXPECT_NE(refusalOf({pointAt({{0, 0, 0}, {0, 0, 0}})}, 1e-3).find("at most"), std::string::npos);
}

TEST(FeatureWarp, IsTheSameForAnyNumberOfThreads) {
  expectSameForThreads([] {
    const FeatureWarp warp({warpObject(shapes::sphere({0, 0, 0}, 6)), warpObject(shapes::box({9, 5, 4}, 2))},
                           kWarpVoxel, {pointAt({{5, 0, 0}, {9, 0, 0}}), pointAt({{-5, 0, 0}, {-9, 0, 0}})});
    return warp.frame({0.5, 0.5});
  });
}

}  // namespace
}  // namespace slicemorph
