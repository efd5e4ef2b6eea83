// The nearest rotation against brute force, and by Newton's steps against the singular value decomposition.
#include "engine/numerics/nearest_rotation.h"

#include "tests/support/random_rotation.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

double traceWith(const Mat3d& rotation, const Mat3d& s) {
  const Mat3d m = rotation.transpose() * s;
  return m(0, 0) + m(1, 1) + m(2, 2);
}

/// Any matrix, or one that is near a rotation times stretches of `least` to 1, mirrored or not.
Mat3d randomMatrix(std::mt19937& random, double least, bool mirrored) {
  std::uniform_real_distribution<double> stretch(least, 1);
  const Mat3d stretches(stretch(random), 0., 0., 0., stretch(random), 0., 0., 0.,
                        (mirrored ? -1 : 1) * least);
  return randomRotation(random) * stretches * randomRotation(random);
}

double difference(const Mat3d& a, const Mat3d& b) {
  double most = 0;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) most = std::max(most, std::abs(a(r, c) - b(r, c)));
  return most;
}

TEST(NearestRotation, NoOtherHasALargerTrace) {
  std::mt19937 random(1);
  for (int i = 0; i < 50; ++i) {
    const Mat3d s = randomMatrix(random, 0.1, i % 2 == 1), nearest = nearestRotation(s);
    EXPECT_NEAR(nearest.det(), 1, 1e-12);
    EXPECT_LE(difference(nearest * nearest.transpose(), Mat3d::identity()), 1e-12);
    for (int k = 0; k < 2000; ++k)
      EXPECT_LE(traceWith(randomRotation(random), s), traceWith(nearest, s) + 1e-12);
  }
}

/// From anywhere, near or far, Newton's steps end where the decomposition does. Both are exact to rounding over the
/// matrix' condition (1 / .05 here, where the two smallest stretches differ least).
TEST(NearestRotation, FromAnyStartTheSame) {
  std::mt19937 random(2);
  for (int i = 0; i < 2000; ++i) {
    const Mat3d s = randomMatrix(random, 0.05, false), wanted = nearestRotation(s);
    EXPECT_LE(difference(nearestRotation(s, randomRotation(random)), wanted), 1e-11);
    EXPECT_LE(difference(nearestRotation(s, wanted), wanted), 1e-11);
  }
}

TEST(NearestRotation, OfMirroredAndFlatMatricesToo) {
  std::mt19937 random(3);
  for (int i = 0; i < 200; ++i) {
    const Mat3d mirrored = randomMatrix(random, 0.05, true), flat = randomMatrix(random, 0, false);
    for (const Mat3d& s : {mirrored, flat}) {
      const Mat3d from = nearestRotation(s, randomRotation(random));
      EXPECT_NEAR(from.det(), 1, 1e-12);
      EXPECT_NEAR(traceWith(from, s), traceWith(nearestRotation(s), s), 1e-12);
    }
  }
}

TEST(NearestRotation, OfNothingIsARotation) {
  EXPECT_NEAR(nearestRotation(Mat3d::zero(), Mat3d::identity()).det(), 1, 1e-12);
}

}  // namespace
}  // namespace slicemorph
