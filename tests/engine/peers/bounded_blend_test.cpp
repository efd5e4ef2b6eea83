#include "engine/peers/bounded_blend.h"

#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kBoundVoxel = 0.5;

/// Outside the bounding object it is the union, to the bit; inside it adds what the formula says: where both functions are
/// 0, the most; where their mean square is the bound's, (1 / 2)^3 / (3 / 2) of it; next to the bound's end, nothing.
TEST(BoundedUnion, IsUnchangedOutsideItsBoundingObject) {
  for (const double bound : {0.0, -0.5, -100.0})
    for (const double f : {-3.0, 0.0, 0.1})
      EXPECT_EQ(boundedUnion({f, -1, 0.01}, {0.2, 0.3, 0.5}, bound, 10, 2), std::max(f, 0.01));
  EXPECT_EQ(boundedUnion({0, 0}, {0.5, 0.5}, 2, 10, 1), 10);
  EXPECT_DOUBLE_EQ(boundedUnion({-2, -2}, {0.5, 0.5}, 2, 10, 1), -2 + 10 / 12.0);
  EXPECT_DOUBLE_EQ(boundedUnion({-2, -4}, {0.5, 0.5}, std::sqrt(2.5), 10, 2), -2 + 10 / 12.0);
  EXPECT_NEAR(boundedUnion({-2, -3}, {0.5, 0.5}, 1e-6, 10, 1), -2, 1e-9);
  // An object of weight 0 counts for nothing.
  EXPECT_EQ(boundedUnion({-2, -3, -100}, {0.5, 0.5, 0}, 1, 10, 1),
            boundedUnion({-2, -3}, {0.5, 0.5}, 1, 10, 1));
}

/// The same function along a ray from the centre of balls, written out for two; its outermost zero by bisection.
double blendedRadius(double a, double b, double t, double gap) {
  const auto function = [&](double at) {
    const double f = a - at, g = b - at, lastsF = gap * (0.25 - t), lastsG = gap * (t - 0.75);
    const double first = f + lastsF - std::sqrt(f * f + lastsF * lastsF);
    const double second = g + lastsG - std::sqrt(g * g + lastsG * lastsG);
    const double bound = std::min(gap * std::min(t, 1 - t), gap + std::max(f, g));
    if (bound <= 0) return std::max(first, second);
    const double m = ((1 - t) * first * first + t * second * second) / 9;
    const double r2 = m / (m + bound * bound);
    return std::max(first, second) + 0.75 * gap * std::pow(1 - r2, 3) / (1 + r2);
  };
  double out = 20;
  while (function(out) < 0) out -= 0.01;
  double in = out, up = out + 0.01;
  for (int i = 0; i < 40; ++i) (function((in + up) / 2) < 0 ? up : in) = (in + up) / 2;
  return in;
}

/// Distances are off by h^2 / 8 / r within the band and by a few hundredths of a coarse node (26 / 112) beyond it, a tenth
/// of a voxel; the blend's zero moves by more where the blend is flat. Half a voxel.
TEST(BoundedBlend, OfBallsIsABall) {
  const BoundedBlend morph({shapes::ball(kBoundVoxel, 5), shapes::ball(kBoundVoxel, 10)}, kBoundVoxel);
  // Voxels nearer than three to the larger ball make its box.
  EXPECT_NEAR(morph.gap(), 0.3 * std::sqrt(3.0) * 2 * 11, 1e-9);
  for (const double t : {0.0, 0.1, 0.3, 0.5, 0.7, 0.9, 1.0}) {
    const FloatGrid::Ptr frame = morph.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    const std::vector<Vec3d> points = surfacePoints(*frame);
    ASSERT_FALSE(points.empty());
    const double radius = blendedRadius(5, 10, t, morph.gap());
    for (const Vec3d& p : points) ASSERT_NEAR(p.length(), radius, 0.5 * kBoundVoxel) << t;
  }
}

TEST(BoundedBlend, KeepsEachOfManyAtItsTime) {
  const std::vector<FloatGrid::ConstPtr> balls{shapes::ball(kBoundVoxel, 5),
                                               shapes::ball(kBoundVoxel, 4, {6, 0, 0}),
                                               shapes::ball(kBoundVoxel, 6, {0, 5, 0})};
  const std::vector<shapes::Distance> shapes{shapes::sphere({0, 0, 0}, 5), shapes::sphere({6, 0, 0}, 4),
                                             shapes::sphere({0, 5, 0}, 6)};
  const BoundedBlend morph(balls, kBoundVoxel);
  for (size_t k = 0; k < 3; ++k) {
    Weights weights(3, 0.0);
    weights[k] = 1;
    for (const Vec3d& p : surfacePoints(*morph.frame(weights)))
      ASSERT_NEAR(shapes[k](p), 0, 0.1 * kBoundVoxel);
  }
  EXPECT_FALSE(surfacePoints(*morph.frame({0.3, 0.3, 0.4})).empty());
}

TEST(BoundedBlend, RefusesWhatItCannotTake) {
  EXPECT_NE(refusal([] {
              BoundedBlend({shapes::ball(kBoundVoxel, 4)}, 0.001);
            }).find("--method bounded-blend needs"),
            std::string::npos);
  const BoundedBlend morph({shapes::ball(kBoundVoxel, 4), shapes::ball(kBoundVoxel, 6)}, kBoundVoxel);
  EXPECT_EQ(refusal([&] { morph.frame({1}); }), "1 weights for 2 objects");
}

TEST(BoundedBlend, IsCancelled) {
  class Stopped : public Progress {
    bool cancelled() const override { return true; }
  } stopped;
  EXPECT_THROW(
      BoundedBlend({shapes::ball(kBoundVoxel, 4), shapes::ball(kBoundVoxel, 6)}, kBoundVoxel, {}, &stopped),
      Cancelled);
}

TEST(BoundedBlend, DoesNotDependOnTheNumberOfThreads) {
  expectSameForThreads([] {
    return BoundedBlend({shapes::ball(kBoundVoxel, 5), shapes::ball(kBoundVoxel, 5, {3, 1, 0})}, kBoundVoxel)
        .frame({0.4, 0.6});
  });
}

}  // namespace
}  // namespace slicemorph
