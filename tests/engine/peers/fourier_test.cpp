#include "engine/peers/fourier.h"

#include "slicemorph/measure.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kWaveVoxel = 0.5;

ScheduledDissolve fourierOf(const std::vector<FloatGrid::ConstPtr>& levelSets, double fade, double cutoff,
                            double voxelSize = kWaveVoxel) {
  return {levelSets, voxelSize, fade, cosineTransform(cutoff), "fourier"};
}

TEST(ScheduledShare, EndsExactlyAndIsMonotone) {
  for (const double fade : {0.0, 0.3, 1.0})
    for (const double fineness : {0.0, 0.5, 1.0}) {
      EXPECT_EQ(scheduledShare(0, fineness, fade), 0);
      EXPECT_EQ(scheduledShare(1, fineness, fade), 1);
      for (int i = 0; i < 10; ++i) {
        EXPECT_LE(scheduledShare(0.1 * i, fineness, fade), scheduledShare(0.1 * i + 0.1, fineness, fade));
        EXPECT_GE(scheduledShare(0.1 * i, fineness, fade), scheduledShare(0.1 * i, fineness + 0.1, fade));
      }
    }
  EXPECT_DOUBLE_EQ(scheduledShare(0.3, 0, 0.5), 0.3);
  EXPECT_DOUBLE_EQ(scheduledShare(0.75, 1, 0.5), 0.5);
  EXPECT_DOUBLE_EQ(scheduledShare(0.75, 0.5, 0.5), 5.0 / 7);
  EXPECT_EQ(scheduledShare(0.5, 1, 0.5), 0);
}

/// A product of cosines is one part of its series, with half the root of twice the intervals for each axis whose cosine
/// is none of the ends of the series, and the root itself for a constant. Single precision: 2^-24 of the value, and as
/// much again for each of three axes.
TEST(CosineTransform, OfCosinesIsOnePart) {
  const auto transform = cosineTransform(8);
  Lattice lattice;
  lattice.size = {transform->nodes(8), transform->nodes(13), transform->nodes(5)};
  EXPECT_EQ(lattice.size, openvdb::Coord(9, 13, 5));
  std::vector<float> values(lattice.count());
  for (size_t n = 0; n < values.size(); ++n) {
    const openvdb::Coord c = lattice.coordOf(n);
    values[n] = float(std::cos(M_PI * 3 * c[0] / 8) * std::cos(M_PI * 5 * c[1] / 12));
  }
  std::vector<float> parts = values;
  transform->forward(lattice, parts);
  const double expected = std::sqrt(16) / 2 * std::sqrt(24) / 2 * std::sqrt(8);
  for (size_t n = 0; n < parts.size(); ++n)
    EXPECT_NEAR(parts[n], n == lattice.index(3, 5, 0) ? expected : 0, 1e-5) << lattice.coordOf(n);
  transform->inverse(lattice, parts);
  for (size_t n = 0; n < parts.size(); ++n) EXPECT_NEAR(parts[n], values[n], 1e-5);

  // 3 half waves along 8 intervals and 5 along 12 are 4.5 and 5 along 12.
  EXPECT_DOUBLE_EQ(transform->fineness(lattice, {3, 5, 0}), std::hypot(4.5, 5) / 8);
  EXPECT_EQ(transform->fineness(lattice, {0, 0, 0}), 0);
  EXPECT_EQ(transform->fineness(lattice, {8, 12, 4}), 1);
}

/// At the ends all parts of one object are there and none of the other. With fade = 1 there is no schedule: distances are
/// blended, and with them the radii of balls about one centre. Linear values between voxels cut a ball by h^2 / 8 / r, an
/// eightieth of a voxel, in inputs, in-between and mesh; distances beyond the band are exact to a few hundredths of a
/// coarse node (26 / 112, half a voxel) for each object: a sixth of a voxel in all.
TEST(Fourier, BlendsRadii) {
  for (const double fade : {0.5, 1.0}) {
    const ScheduledDissolve morph =
        fourierOf({shapes::ball(kWaveVoxel, 5), shapes::ball(kWaveVoxel, 10)}, fade, 16);
    for (const double t : {0.0, 0.25, 0.5, 1.0}) {
      if (fade < 1 && t > 0 && t < 1) continue;
      const FloatGrid::Ptr frame = morph.frame({1 - t, t});
      EXPECT_EQ(frame->getName(), "surface");
      const std::vector<Vec3d> points = surfacePoints(*frame);
      ASSERT_FALSE(points.empty());
      for (const Vec3d& p : points) ASSERT_NEAR(p.length(), 5 + 5 * t, kWaveVoxel / 6) << fade << " " << t;
    }
  }
  const ScheduledDissolve three = fourierOf(
      {shapes::ball(kWaveVoxel, 5), shapes::ball(kWaveVoxel, 10), shapes::ball(kWaveVoxel, 7)}, 1, 16);
  for (const Vec3d& p : surfacePoints(*three.frame({0.25, 0.25, 0.5})))
    ASSERT_NEAR(p.length(), 7.25, kWaveVoxel / 6);
}

TEST(Fourier, GrowsWithoutTurningBack) {
  const ScheduledDissolve morph =
      fourierOf({shapes::ball(kWaveVoxel, 5), shapes::ball(kWaveVoxel, 10)}, 0.5, 16);
  double before = 0;
  for (int i = 0; i <= 8; ++i) {
    const double volume = measureShape(*morph.frame({1 - i / 8.0, i / 8.0})).volume;
    EXPECT_GT(volume, before) << i;
    before = volume;
  }
}

/// The largest less the smallest radius around the equator.
double ripple(const FloatGrid& frame) {
  double low = 1e9, high = 0;
  for (const Vec3d& p : surfacePoints(frame))
    if (std::abs(p[2]) < kWaveVoxel) low = std::min(low, p.length()), high = std::max(high, p.length());
  return high - low;
}

/// Twelve ripples around a ball become the ball: half way, where distances alone would leave half of their height, those
/// fine parts are gone. What they have of coarser parts stays: a fifth at most.
TEST(Fourier, FadesDetailFirst) {
  const auto rippled = [](const Vec3d& p) {
    const double around = std::hypot(p[0], p[1]) / std::max(p.length(), 1e-9);
    return p.length() - 9 - 0.6 * std::pow(around, 12) * std::cos(12 * std::atan2(p[1], p[0]));
  };
  const FloatGrid::ConstPtr a = shapes::levelSet(rippled, shapes::cube(Vec3d(0.0), 13), kWaveVoxel);
  const double whole = ripple(*a);
  EXPECT_NEAR(whole, 1.2, 0.2);
  EXPECT_GT(ripple(*fourierOf({a, shapes::ball(kWaveVoxel, 9)}, 1, 8).frame({0.5, 0.5})), 0.4 * whole);
  EXPECT_LT(ripple(*fourierOf({a, shapes::ball(kWaveVoxel, 9)}, 0.5, 8).frame({0.5, 0.5})), 0.2 * whole);
}

TEST(Fourier, RefusesWhatItCannotTake) {
  EXPECT_NE(refusal([] {
              fourierOf({shapes::ball(kWaveVoxel, 5), shapes::ball(kWaveVoxel, 8)}, 0.5, 16, 0.01);
            }).find("--method fourier"),
            std::string::npos);
  const ScheduledDissolve morph =
      fourierOf({shapes::ball(kWaveVoxel, 3), shapes::ball(kWaveVoxel, 4)}, 0.5, 16);
  EXPECT_EQ(refusal([&] { morph.frame({1}); }), "1 weights for 2 objects");
}

TEST(Fourier, IsCancelled) {
  class Stopped : public Progress {
    bool cancelled() const override { return true; }
  } stopped;
  EXPECT_THROW(ScheduledDissolve({shapes::ball(kWaveVoxel, 3), shapes::ball(kWaveVoxel, 4)}, kWaveVoxel, 0.5,
                                 cosineTransform(16), "fourier", &stopped),
               Cancelled);
}

TEST(Fourier, DoesNotDependOnTheNumberOfThreads) {
  expectSameForThreads([] {
    return fourierOf({shapes::ball(kWaveVoxel, 3), shapes::ball(kWaveVoxel, 5)}, 0.5, 16).frame({0.4, 0.6});
  });
}

}  // namespace
}  // namespace slicemorph
