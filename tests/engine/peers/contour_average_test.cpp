#include "engine/peers/contour_average.h"

#include "slicemorph/errors.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kAverageVoxel = 0.5;

Object averageBall(double radius, const Vec3d& centre = Vec3d(0.0)) {
  return {"ball",
          shapes::levelSet(shapes::sphere(centre, radius), shapes::cube(centre, radius + 3), kAverageVoxel)};
}

double farthestOff(const FloatGrid& frame, const shapes::Distance& shape) {
  double farthest = 0;
  for (const Vec3d& p : surfacePoints(frame)) farthest = std::max(farthest, std::abs(shape(p)));
  return farthest;
}

/// How far a ball of this radius is off when it is rebuilt from flat slabs: the corner of the last one, at the height of
/// the pole and as wide as the slice in its middle, is half a slab's thickness from the ball. To this comes a tenth of a
/// voxel for what pixels and voxels cut (h^2 / 8 / radius each).
double slabTolerance(double radius, int slices) { return radius / slices + 0.1 * kAverageVoxel; }

TEST(ContourAverage, AveragesPoints) {
  const std::vector<Vec2d> points{{0, 0}, {1, 0}, {5, 0}, {1.2, 0}};
  const Weights equal(4, 0.25);
  EXPECT_NEAR(averageOf(ContourAverageKind::kMean, points, equal, 1)[0], 1.8, 1e-12);
  // Weighted sums of distances: from 0 they are 1.79, from 1: 1.29, from 5: 3.21, from 1.2: 1.31.
  EXPECT_EQ(averageOf(ContourAverageKind::kMedian, points, {0.25, 0.3, 0.25, 0.2}, 1), Vec2d(1, 0));
  EXPECT_EQ(averageOf(ContourAverageKind::kMedian, points, {0.1, 0.1, 0.7, 0.1}, 1), Vec2d(5, 0));
  // Two lie within 0.5 of each other.
  EXPECT_NEAR(averageOf(ContourAverageKind::kMode, points, equal, 0.5)[0], 1.1, 1e-12);
  EXPECT_NEAR(averageOf(ContourAverageKind::kMode, points, {0.1, 0.1, 0.7, 0.1}, 0.5)[0], 5, 1e-12);
}

/// A U in a square of side 4: its bay, ten long, belongs to the hull's upper edge.
TEST(ContourAverage, MatchesBaysToTheEdgesOfTheHull) {
  std::vector<Vec2d> u{{0, 0}, {4, 0}, {4, 4}, {3, 4}, {3, 1}, {1, 1}, {1, 4}, {0, 4}};
  const std::vector<Vec2d> expected{{4, 2}, {2, 1}, {0, 2}, {2, 0}};
  for (int turn = 0; turn < 2; ++turn) {
    const std::vector<Vec2d> samples = hullSamples(u, 4);
    ASSERT_EQ(samples.size(), 4u);
    for (size_t i = 0; i < 4; ++i) EXPECT_LT((samples[i] - expected[i]).length(), 1e-12) << turn << i;
    std::reverse(u.begin(), u.end());
  }
}

/// Slices of balls about one centre at the same share of their heights are circles in the ratio of the balls' radii, and
/// so are their heights.
TEST(ContourAverage, OfThreeBallsIsABall) {
  const std::vector<Object> balls{averageBall(4), averageBall(12), averageBall(6)};
  const Weights equal(3, 1.0 / 3);
  ContourAverageOptions options;
  const auto off = [&](ContourAverageKind kind, const std::vector<Object>& objects, double radius) {
    options.kind = kind;
    const FloatGrid::Ptr frame = ContourAverage(objects, kAverageVoxel, Vec3d(0.0), options).frame(equal);
    EXPECT_EQ(frame->getName(), "surface");
    return farthestOff(*frame, shapes::sphere(Vec3d(0.0), radius)) / slabTolerance(radius, options.slices);
  };
  EXPECT_LT(off(ContourAverageKind::kMean, balls, 22.0 / 3), 1);
  EXPECT_LT(off(ContourAverageKind::kMedian, balls, 6), 1);
  // Radii of 6 and 6.4 are nearer to each other than a tenth of the mean radius, 8.13.
  EXPECT_LT(off(ContourAverageKind::kMode, {averageBall(6), averageBall(12), averageBall(6.4)}, 6.2), 1);
}

/// At weight 1 an object is its own average, cut into slices across the given axis: two balls beside each other, and a
/// ring with its hole.
TEST(ContourAverage, KeepsPartsAndHoles) {
  const auto two = shapes::joined({shapes::sphere({-9, 0, 0}, 6), shapes::sphere({9, 0, 0}, 6)});
  const auto ring = shapes::torus({0, 0, 0}, 10, 5);
  const std::vector<Object> objects{
      {"two", shapes::levelSet(two, shapes::cube(Vec3d(0.0), 20), kAverageVoxel)},
      {"ring", shapes::levelSet(ring, shapes::cube(Vec3d(0.0), 20), kAverageVoxel)}};
  const ContourAverage average(objects, kAverageVoxel, {0, 0, 2});
  EXPECT_LT(farthestOff(*average.frame({1, 0}), two), slabTolerance(6, 96));
  // The ring's first slab is wider than a ball's of its tube by as much as its middle lies off the axis: the same bound.
  EXPECT_LT(farthestOff(*average.frame({0, 1}), ring), slabTolerance(5, 96));
  EXPECT_NE(average.frame({0.5, 0.5})->activeVoxelCount(), 0u);
}

TEST(ContourAverage, RefusesWhatItCannotTake) {
  const std::vector<Object> balls{averageBall(4), averageBall(6)};
  ContourAverageOptions options;
  options.kind = ContourAverageKind::kMode;
  options.width = 0;
  const auto make = [&](double voxelSize) { ContourAverage(balls, voxelSize, Vec3d(0.0), options); };
  EXPECT_NE(refusal([&] { make(kAverageVoxel); }).find("--method contour-mode: width is 0"),
            std::string::npos);
  options.width = 0.1, options.slices = 1;
  EXPECT_NE(refusal([&] { make(kAverageVoxel); }).find("slices is 1"), std::string::npos);
  options.slices = 64;
  EXPECT_NE(refusal([&] { make(1e-4); }).find("at most"), std::string::npos);
  EXPECT_THROW(ContourAverage(balls, kAverageVoxel, Vec3d(0.0)).frame({1}), InputError);
}

TEST(ContourAverage, IsTheSameForAnyNumberOfThreads) {
  expectSameForThreads([] {
    return ContourAverage({averageBall(5), averageBall(7, {3, 1, 2})}, kAverageVoxel, Vec3d(0.0))
        .frame({0.5, 0.5});
  });
}

}  // namespace
}  // namespace slicemorph
