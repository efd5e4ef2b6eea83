// Matching through the mean where the mean and every map are known: balls about one middle.
#include "engine/mean/match_through_mean.h"

#include "slicemorph/errors.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kVoxel = 1.0 / 32;
const std::vector<double> kRadii{0.7, 1.0, 1.3};

Frames framesOf(const MatchObjects& objects) {
  Frames frames;
  frames.charts = objects.charts, frames.halfLength = 1.3;
  return frames;
}

/// Balls in one chart, which is the world: chart space does not make them equal.
Registration matched(const MatchObjects& objects) {
  const Frames frames = framesOf(objects);
  const MorphOptions options;
  Registration start =
      startRegistration(objects, traceObjects(sliceObjects(objects, options.slices)), options.samples);
  Progress progress;
  return matchThroughMean(std::move(start), objects, frames, {"a", "b", "c"}, options, progress);
}

MatchObjects balls() {
  Fields fields;
  for (double radius : kRadii)
    fields.push_back(
        shapes::fieldOf(shapes::sphere(Vec3d(0.0), radius), {Vec3d(-radius), Vec3d(radius)}, kVoxel));
  return measureObjects(fields, {}, std::vector<Chart>(kRadii.size()), {});
}

/// The mean ball has the mean radius, 1, and every direction meets itself: a middle point is the mean of its positions,
/// and a ball's point at p is the middle point p over its radius. Overlaps are measured on a lattice whose cells
/// are .035 of the box, .1 here; the closest points' rounds settle what is left to a tenth of that.
TEST(MatchThroughMean, OfBallsIsTheBallOfTheMeanRadius) {
  const MatchObjects objects = balls();
  const Registration r = matched(objects);
  ASSERT_EQ(r.map.of.size(), kRadii.size());
  double offCentre = 0, off = 0, aside = 0;
  for (int i = 0; i < 400; ++i) {
    // Evenly spread directions (golden angle).
    const double z = 1 - (2 * i + 1) / 400.0, angle = i * 2.39996322972865332;
    const double around = std::sqrt(1 - z * z);
    const Vec3d direction(around * std::cos(angle), around * std::sin(angle), z);
    Vec3d sum(0.0);
    for (size_t k = 0; k < kRadii.size(); ++k) {
      sum += r.map.at(k, direction) / double(kRadii.size());
      const Vec3d own = kRadii[k] * direction;
      Vec3d s = direction;
      ASSERT_TRUE(toMiddle(r.map, k, own, s));
      off = std::max(off, std::abs(s.length() - 1));
      aside = std::max(aside, (s - s.dot(direction) * direction).length());
    }
    offCentre = std::max(offCentre, sum.length());
  }
  std::printf("  off the mean %.4f, off the radius %.4f, aside %.4f\n", offCentre, off, aside);
  EXPECT_LT(offCentre, 0.01);
  EXPECT_LT(off, 0.03);
  EXPECT_LT(aside, 0.05);
  // Two surfaces that are each off by so much of a radius of 1, by six times that of the volume; an overlap itself is
  // measured to .006 (stages_test).
  EXPECT_GT(r.overlapAfter, 1 - 6 * off - 0.006);
}

/// Work that was cancelled gives nothing.
struct CancelledWork : Progress {
  bool cancelled() const override { return true; }
};

TEST(MatchThroughMean, ACancelledOneThrows) {
  const MatchObjects objects = balls();
  Registration start = startRegistration(objects, traceObjects(sliceObjects(objects, 32)), 64);
  CancelledWork progress;
  EXPECT_THROW(matchThroughMean(std::move(start), objects, framesOf(objects), {"a", "b", "c"}, MorphOptions{},
                                progress),
               Cancelled);
}

}  // namespace
}  // namespace slicemorph
