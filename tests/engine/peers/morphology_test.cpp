#include "engine/peers/morphology.h"

#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kGrownVoxel = 0.5;

/// Balls about one centre: the smallest, of radius c, is the common part, and the ball of radius r and weight w reaches
/// w r + (1 - w) c. The in-between has the largest of these radii. Linear values between voxels cut a ball by h^2 / 8 / c,
/// a sixtieth of a voxel, in each of four level sets (inputs, common part, in-between, mesh); distances beyond the band
/// are exact to a few hundredths of a coarse node (30 / 112 at most, half a voxel), of inputs and common part: a sixth of
/// a voxel in all.
constexpr double kGrownTolerance = kGrownVoxel / 6;
TEST(Morphology, GrowsAndShrinksBalls) {
  const MorphologyMorph two({shapes::ball(kGrownVoxel, 4), shapes::ball(kGrownVoxel, 12)}, kGrownVoxel);
  for (const double t : {0.0, 0.25, 0.5, 0.9, 1.0}) {
    const FloatGrid::Ptr frame = two.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    const std::vector<Vec3d> points = surfacePoints(*frame);
    ASSERT_FALSE(points.empty());
    for (const Vec3d& p : points) ASSERT_NEAR(p.length(), 4 + 8 * t, kGrownTolerance) << t;
  }
  const MorphologyMorph three(
      {shapes::ball(kGrownVoxel, 4), shapes::ball(kGrownVoxel, 12), shapes::ball(kGrownVoxel, 8)},
      kGrownVoxel);
  for (const Vec3d& p : surfacePoints(*three.frame({0.2, 0.2, 0.6})))
    ASSERT_NEAR(p.length(), 0.6 * 8 + 0.4 * 4, kGrownTolerance);
}

/// Balls of radius 8 whose centres are 6 apart: on the line through both the common lens reaches from -2 to 8, the balls
/// from -8 to 8 and from -2 to 14. So the in-between reaches from -8 w - 2 (1 - w) to 14 (1 - w) + 8 w. The lens' tips,
/// there, are parts of the spheres.
TEST(Morphology, ErodesOneDifferenceWhileTheOtherIsDilated) {
  const MorphologyMorph morph({shapes::ball(kGrownVoxel, 8), shapes::ball(kGrownVoxel, 8, {6, 0, 0})},
                              kGrownVoxel);
  for (const double w : {1.0, 0.7, 0.5, 0.2, 0.0}) {
    double low = 0, high = 0;
    for (const Vec3d& p : surfacePoints(*morph.frame({w, 1 - w})))
      low = std::min(low, p[0]), high = std::max(high, p[0]);
    EXPECT_NEAR(low, -8 * w - 2 * (1 - w), kGrownTolerance) << w;
    EXPECT_NEAR(high, 14 * (1 - w) + 8 * w, kGrownTolerance) << w;
  }
}

TEST(Morphology, RefusesWhatItCannotTake) {
  EXPECT_NE(refusal([] {
              MorphologyMorph({shapes::ball(kGrownVoxel, 4), shapes::ball(kGrownVoxel, 4, {20, 0, 0})},
                              kGrownVoxel);
            }).find("have none"),
            std::string::npos);
  EXPECT_NE(refusal([] { MorphologyMorph({shapes::ball(kGrownVoxel, 4)}, 0.001); }).find("at most"),
            std::string::npos);
  const MorphologyMorph morph({shapes::ball(kGrownVoxel, 4), shapes::ball(kGrownVoxel, 6)}, kGrownVoxel);
  EXPECT_EQ(refusal([&] { morph.frame({1}); }), "1 weights for 2 objects");
}

TEST(Morphology, IsCancelled) {
  class Stopped : public Progress {
    bool cancelled() const override { return true; }
  } stopped;
  EXPECT_THROW(
      MorphologyMorph({shapes::ball(kGrownVoxel, 4), shapes::ball(kGrownVoxel, 6)}, kGrownVoxel, &stopped),
      Cancelled);
}

TEST(Morphology, DoesNotDependOnTheNumberOfThreads) {
  expectSameForThreads([] {
    return MorphologyMorph({shapes::ball(kGrownVoxel, 5), shapes::ball(kGrownVoxel, 5, {3, 1, 0})},
                           kGrownVoxel)
        .frame({0.4, 0.6});
  });
}

}  // namespace
}  // namespace slicemorph
