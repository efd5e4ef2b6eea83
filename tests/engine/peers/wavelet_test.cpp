#include "engine/peers/wavelet.h"

#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kLevelVoxel = 0.5;

ScheduledDissolve waveletOf(const std::vector<FloatGrid::ConstPtr>& levelSets, double fade, int levels,
                            double voxelSize = kLevelVoxel) {
  return {levelSets, voxelSize, fade, haarTransform(levels), "wavelet"};
}

/// By hand: 1 and 3 have mean 2 and half difference -1, 5 and 11 have 8 and -3; of 2 and 8 the mean is 5, and -3 half the
/// difference.
TEST(HaarTransform, IsOfMeansAndDifferences) {
  const auto transform = haarTransform(2);
  Lattice lattice;
  lattice.size = {transform->nodes(3), transform->nodes(1), transform->nodes(5)};
  EXPECT_EQ(lattice.size, openvdb::Coord(4, 4, 8));
  const float line[4] = {1, 3, 5, 11}, expected[4] = {5, -1, -3, -3};
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<float> values(lattice.count());
    for (size_t n = 0; n < values.size(); ++n) values[n] = line[lattice.coordOf(n)[axis] % 4];
    std::vector<float> parts = values;
    transform->forward(lattice, parts);
    for (size_t n = 0; n < parts.size(); ++n) {
      openvdb::Coord c = lattice.coordOf(n);
      const int at = c[axis] % 4;
      c[axis] = 0;
      // Along the other axes nothing changes: their details are 0, and there is a mean for every block of the level.
      const int block = at % 2 ? 2 : 4;
      const bool mean = c[0] % block == 0 && c[1] % block == 0 && c[2] % block == 0;
      EXPECT_EQ(parts[n], mean ? expected[at] : 0) << axis << lattice.coordOf(n);
    }
    transform->inverse(lattice, parts);
    EXPECT_EQ(parts, values);
  }
  EXPECT_EQ(transform->fineness(lattice, {4, 0, 4}), 0);
  EXPECT_EQ(transform->fineness(lattice, {4, 2, 4}), 0.5);
  EXPECT_EQ(transform->fineness(lattice, {2, 3, 4}), 1);
}

/// As of the Fourier dissolve: inputs at the ends; and without schedule the blend of distances.
TEST(Wavelet, BlendsRadii) {
  const ScheduledDissolve scheduled =
      waveletOf({shapes::ball(kLevelVoxel, 5), shapes::ball(kLevelVoxel, 10)}, 0.5, 4);
  const ScheduledDissolve plain =
      waveletOf({shapes::ball(kLevelVoxel, 5), shapes::ball(kLevelVoxel, 10)}, 1, 4);
  const auto expectRadius = [](const FloatGrid& frame, double radius) {
    EXPECT_EQ(frame.getName(), "surface");
    const std::vector<Vec3d> points = surfacePoints(frame);
    ASSERT_FALSE(points.empty());
    for (const Vec3d& p : points) ASSERT_NEAR(p.length(), radius, kLevelVoxel / 6);
  };
  expectRadius(*scheduled.frame({1, 0}), 5);
  expectRadius(*scheduled.frame({0, 1}), 10);
  for (const double t : {0.25, 0.5, 0.75}) expectRadius(*plain.frame({1 - t, t}), 5 + 5 * t);
  expectRadius(
      *waveletOf({shapes::ball(kLevelVoxel, 5), shapes::ball(kLevelVoxel, 10), shapes::ball(kLevelVoxel, 7)},
                 1, 3)
           .frame({0.25, 0.25, 0.5}),
      7.25);
}

/// Half way, with fade = 0 and one level, all details are gone: blocks of two voxels have one value each, the one at their
/// middle. What is read as linear from block to block is a staircase, off by no more than half a block's diagonal, but by
/// more than any smooth blend.
TEST(Wavelet, LeavesBlocksHalfWay) {
  const FloatGrid::Ptr frame =
      waveletOf({shapes::ball(kLevelVoxel, 6), shapes::ball(kLevelVoxel, 8)}, 0, 1).frame({0.5, 0.5});
  double off = 0;
  for (const Vec3d& p : surfacePoints(*frame)) off = std::max(off, std::abs(p.length() - 7));
  EXPECT_GT(off, 0.25 * kLevelVoxel);
  EXPECT_LT(off, std::sqrt(3.0) * kLevelVoxel);
}

TEST(Wavelet, RefusesWhatItCannotTake) {
  EXPECT_NE(refusal([] {
              waveletOf({shapes::ball(kLevelVoxel, 5), shapes::ball(kLevelVoxel, 8)}, 0.5, 4, 0.01);
            }).find("--method wavelet"),
            std::string::npos);
  const ScheduledDissolve morph =
      waveletOf({shapes::ball(kLevelVoxel, 3), shapes::ball(kLevelVoxel, 4)}, 0.5, 4);
  EXPECT_EQ(refusal([&] { morph.frame({1}); }), "1 weights for 2 objects");
}

TEST(Wavelet, DoesNotDependOnTheNumberOfThreads) {
  expectSameForThreads([] {
    return waveletOf({shapes::ball(kLevelVoxel, 3), shapes::ball(kLevelVoxel, 5)}, 0.5, 4).frame({0.4, 0.6});
  });
}

}  // namespace
}  // namespace slicemorph
