// Bodies coupled by what does not change when limbs swing.
#include "engine/match/couple_bodies.h"

#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

using shapes::capsule;

const openvdb::BBoxd kCoupledBox(Vec3d(-1.8), Vec3d(1.8));
const Vec3d kHinge(0, 0.9, 0);

/// A thick trunk with a stub below and an arm at its upper end, whose direction is `angle` from sideways.
shapes::Distance figure(double angle) {
  const Vec3d tip = kHinge + 1.1 * Vec3d(std::cos(angle), std::sin(angle), 0);
  return shapes::joined({capsule({0, -0.9, 0}, {0, 0.7, 0}, 0.3),
                         capsule({0, -0.9, 0}, {0.7, -1.3, 0.2}, 0.17), capsule({0, 0.7, 0}, kHinge, 0.12),
                         capsule(kHinge, tip, 0.12)});
}

BodyGraph graphOf(const shapes::Distance& shape) {
  return bodyGraph(*shapes::fieldOf(shape, kCoupledBox, 0.03), shapes::straightChart());
}

/// An arm that swings by 100 degrees: its nodes go where it is, and the trunk stays. A coupling is blurred by a quarter of
/// the mean inner distance, some .9 here, to either side, which draws tips in by half of it at most; bending the body
/// sharpens it. An arm that is not found is off by 1.2.
TEST(CoupleBodies, FindsTheArmWhereverItIs) {
  const double from = -0.6, to = 1.15;
  const BodyGraph a = graphOf(figure(from)), b = graphOf(figure(to));
  const BodyCoupling coupling = coupleBodies(a, b);
  EXPECT_LT(coupling.distortion, 0.045);
  const Mat3d swing = rotationFromVector({0, 0, to - from});
  double arm = 0, trunk = 0;
  size_t arms = 0, trunks = 0;
  for (size_t i = 0; i < a.position.size(); ++i) {
    const Vec3d& p = a.position[i];
    if (p[0] > 0.4 && p[1] > -0.2)
      arm += (coupling.pose[0].position[i] - (kHinge + swing * (p - kHinge))).length(), ++arms;
    else if (std::abs(p[0]) < 0.3 && p[1] < 0.4)
      trunk += (coupling.pose[0].position[i] - p).length(), ++trunks;
  }
  ASSERT_GT(arms, 20u);
  ASSERT_GT(trunks, 50u);
  std::printf("  distortion %.4f, arm off by %.3f, trunk by %.3f, spacing %.3f\n", coupling.distortion,
              arm / double(arms), trunk / double(trunks), a.spacing);
  EXPECT_LT(arm / double(arms), 0.5 * 0.9);
  EXPECT_LT(trunk / double(trunks), 2 * a.spacing);
}

/// A ball and a long rod are not of one kind.
TEST(CoupleBodies, TellsOtherKinds) {
  const BodyGraph ball = graphOf(shapes::sphere(Vec3d(0.0), 0.9)),
                  rod = graphOf(capsule({-1.4, 0, 0}, {1.4, 0, 0}, 0.15));
  EXPECT_GT(coupleBodies(ball, rod).distortion, 0.045);
  EXPECT_EQ(coupleBodies(ball, BodyGraph()).pose[0].position.size(), 0u);
}

}  // namespace
}  // namespace slicemorph
