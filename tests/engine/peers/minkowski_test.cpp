#include "engine/peers/minkowski.h"

#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kSumVoxel = 0.5;

FloatGrid::ConstPtr summand(const shapes::Distance& shape, double half, const Vec3d& centre = Vec3d(0.0)) {
  return shapes::levelSet(shape, shapes::cube(centre, half + 3), kSumVoxel);
}

/// A box with sharp edges, half sides.
FloatGrid::ConstPtr sumBox(const Vec3d& half) { return summand(shapes::box(half, 0), 12); }

/// The largest distance of a surface from a shape, of all points and of those that are away from edges.
struct SumError {
  double all = 0, smooth = 0;
};
template <typename Smooth>
SumError sumError(const FloatGrid& frame, const shapes::Distance& shape, const Smooth& smooth) {
  SumError error;
  for (const Vec3d& p : surfacePoints(frame)) {
    const double off = std::abs(shape(p));
    error.all = std::max(error.all, off);
    if (smooth(p)) error.smooth = std::max(error.smooth, off);
  }
  return error;
}

/// Whether no two coordinates are within a voxel of a box' faces.
auto awayFromEdges(const Vec3d& half) {
  return [half](const Vec3d& p) {
    int near = 0;
    for (int a = 0; a < 3; ++a) near += std::abs(p[a]) > half[a] - 2 * kSumVoxel;
    return near < 2;
  };
}

/// The sum of boxes is a box whose sides are blended. Its faces are exact but for single precision. On edges a level set's
/// surface has the mean of what crosses a cell, somewhere in the cell: less than a voxel deep, in inputs as in the frame.
TEST(Minkowski, BlendsTheSidesOfBoxes) {
  const Vec3d a(10, 4, 6), b(4, 8, 3);
  const MinkowskiMorph morph({sumBox(a), sumBox(b)}, kSumVoxel);
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const Vec3d half = (1 - t) * a + t * b;
    const FloatGrid::Ptr frame = morph.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    const SumError error = sumError(*frame, shapes::box(half, 0), awayFromEdges(half));
    EXPECT_LT(error.smooth, 0.01 * kSumVoxel) << t;
    EXPECT_LT(error.all, 2 * kSumVoxel) << t;
  }
}

/// The sum of a box with edges of radius 2 and a ball of radius 8 has edges of a radius between. Directions are pi / 64
/// apart along both circles: facets are lower than a round of radius r by 2 r (pi / 64)^2 / 8, a hundredth of a voxel for
/// r = 8. Each level set and mesh cuts h^2 / 8 / r along two axes, for r = 2 a 16th of a voxel: with input,
/// sum and mesh a quarter of a voxel in all.
TEST(Minkowski, OfABallAndABoxIsARoundBox) {
  const Vec3d half(8, 5, 6), there(2, 1, 0);
  const MinkowskiMorph morph({summand(shapes::box(half, 2), 8), summand(shapes::sphere(there, 8), 8, there)},
                             kSumVoxel);
  for (const double t : {0.0, 0.2, 0.5, 0.8, 1.0}) {
    const auto sum = shapes::placed(shapes::box((1 - t) * half + t * Vec3d(8), (1 - t) * 2 + t * 8),
                                    Mat3d::identity(), t * there);
    EXPECT_LT(sumError(*morph.frame({1 - t, t}), sum, [](const Vec3d&) { return true; }).all,
              0.25 * kSumVoxel)
        << t;
  }
}

/// The sum of a torus, which is not convex, and a ball is a torus with a thicker tube.
TEST(Minkowski, OfATorusAndABallIsATorus) {
  const MinkowskiMorph morph(
      {summand(shapes::torus({0, 0, 0}, 9, 3), 12), summand(shapes::sphere({0, 0, 0}, 4), 4)}, kSumVoxel);
  for (const double t : {0.0, 0.5}) {
    const auto sum = shapes::torus({0, 0, 0}, (1 - t) * 9, (1 - t) * 3 + t * 4);
    EXPECT_LT(sumError(*morph.frame({1 - t, t}), sum, [](const Vec3d&) { return true; }).all,
              0.25 * kSumVoxel)
        << t;
  }
}

TEST(Minkowski, AddsAnyNumberOfObjects) {
  const MinkowskiMorph balls(
      {summand(shapes::sphere({0, 0, 0}, 4), 4), summand(shapes::sphere({0, 0, 0}, 8), 8),
       summand(shapes::sphere({0, 0, 0}, 6), 6)},
      kSumVoxel);
  for (const Vec3d& p : surfacePoints(*balls.frame({0.25, 0.25, 0.5})))
    ASSERT_NEAR(p.length(), 6, 0.25 * kSumVoxel);
  const MinkowskiMorph tori(
      {summand(shapes::torus({0, 0, 0}, 8, 2), 10), summand(shapes::sphere({0, 0, 0}, 4), 4),
       summand(shapes::sphere({0, 0, 0}, 6), 6)},
      kSumVoxel);
  // Two sums, the tolerance of each.
  EXPECT_LT(sumError(*tori.frame({0.5, 0.25, 0.25}), shapes::torus({0, 0, 0}, 4, 3.5),
                     [](const Vec3d&) { return true; })
                .all,
            0.5 * kSumVoxel);
}

TEST(Minkowski, RefusesWhatItCannotTake) {
  const FloatGrid::ConstPtr torus = summand(shapes::torus({0, 0, 0}, 9, 3), 12);
  const MinkowskiMorph morph({torus, torus}, kSumVoxel);
  EXPECT_NE(refusal([&] { morph.frame({1.5, -0.5}); }).find("a weight is below 0"), std::string::npos);
  EXPECT_EQ(refusal([&] { morph.frame({1}); }), "1 weights for 2 objects");
  const MinkowskiMorph fine({torus, torus}, 0.1);
  EXPECT_NE(refusal([&] { fine.frame({0.5, 0.5}); }).find("2.1 million at most"), std::string::npos);
}

TEST(Minkowski, IsCancelled) {
  class Stopped : public Progress {
    bool cancelled() const override { return true; }
  } stopped;
  EXPECT_THROW(MinkowskiMorph({sumBox({4, 4, 4}), sumBox({3, 4, 5})}, kSumVoxel, {}, &stopped), Cancelled);
}

TEST(Minkowski, DoesNotDependOnTheNumberOfThreads) {
  expectSameForThreads([] {
    const MinkowskiMorph morph(
        {summand(shapes::torus({0, 0, 0}, 6, 2), 8), summand(shapes::sphere({0, 0, 0}, 4), 4)}, kSumVoxel);
    return morph.frame({0.4, 0.6});
  });
}

}  // namespace
}  // namespace slicemorph
