#include "engine/peers/variational.h"

#include "slicemorph/measure.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kPlateVoxel = 0.5;

FloatGrid::ConstPtr plateShape(const shapes::Distance& shape, double half) {
  return shapes::levelSet(shape, shapes::cube(Vec3d(0.0), half + 3), kPlateVoxel);
}

/// Points of a sphere, and of one inside it, at the place of an object; x is mirrored on demand.
void addSphere(std::vector<VariationalConstraint>& constraints, const Vec3d& centre, double radius,
               const Weights& place, bool mirrored) {
  for (int i = 0; i < 40; ++i) {
    const double z = (i + 0.5) / 20 - 1, angle = 2.4 * i, around = std::sqrt(1 - z * z);
    Vec3d direction(around * std::cos(angle), around * std::sin(angle), z);
    if (mirrored) direction[0] = -direction[0];
    constraints.push_back({centre + radius * direction, place, 0});
    constraints.push_back({centre + 0.9 * radius * direction, place, -0.1 * radius});
  }
}

/// The function has the values that it shall have. Ten digits of sixteen are left by the solution.
TEST(VariationalFunction, PassesThroughItsConstraints) {
  std::vector<VariationalConstraint> constraints;
  addSphere(constraints, {1, 2, 0}, 2, {1, 0, 0}, false);
  addSphere(constraints, {-1, 0, 3}, 3, {0, 1, 0}, false);
  addSphere(constraints, {0, 0, 0}, 1, {0, 0, 1}, false);
  const VariationalFunction function(constraints, 4);
  for (const VariationalConstraint& at : constraints)
    EXPECT_NEAR(VariationalFunction::Slice(function, at.weights)(at.point), at.value, 1e-6);
}

/// An affine function does not bend at all.
TEST(VariationalFunction, IsAffineWhereConstraintsAre) {
  std::vector<VariationalConstraint> constraints;
  addSphere(constraints, {1, 2, 0}, 2, {1, 0}, false);
  addSphere(constraints, {-1, 0, 3}, 3, {0, 1}, false);
  const auto affine = [](const Vec3d& p, const Weights& w) {
    return 0.5 + Vec3d(1, -2, 0.3).dot(p) + 4 * w[0] - w[1];
  };
  for (VariationalConstraint& at : constraints) at.value = affine(at.point, at.weights);
  const VariationalFunction function(constraints, 4);
  for (const double t : {0.0, 0.3, 1.0})
    for (const Vec3d& p : {Vec3d(0, 0, 0), Vec3d(5, -4, 2), Vec3d(-1, 1, 1)})
      EXPECT_NEAR(VariationalFunction::Slice(function, {1 - t, t})(p), affine(p, {1 - t, t}), 1e-6) << t << p;
}

/// Two spheres a plane apart that are each other's mirror images: so are the slices at t and 1 - t.
TEST(VariationalFunction, IsAsSymmetricAsItsConstraints) {
  std::vector<VariationalConstraint> constraints;
  addSphere(constraints, {-1.5, 0, 0}, 2, {1, 0}, false);
  addSphere(constraints, {1.5, 0, 0}, 2, {0, 1}, true);
  const VariationalFunction function(constraints, 3);
  for (const double t : {0.2, 0.5})
    for (const Vec3d& p : {Vec3d(0.5, 0, 0.2), Vec3d(2, 1, -1), Vec3d(-3, 0.2, 1)})
      EXPECT_NEAR(VariationalFunction::Slice(function, {1 - t, t})(p),
                  VariationalFunction::Slice(function, {t, 1 - t})(Vec3d(-p[0], p[1], p[2])), 1e-6);
}

VariationalOptions someHundred() {
  VariationalOptions options;
  options.points = 150;
  return options;
}

/// A ball through 150 points that are a quarter of its radius apart: between them the surface that bends least is off by
/// about the fourth power of that, to which the points' own error is added: a tenth of a voxel. Half a voxel.
TEST(Variational, KeepsBallsAtTheEnds) {
  const VariationalMorph morph(
      {plateShape(shapes::sphere({0, 0, 0}, 5), 5), plateShape(shapes::sphere({0, 0, 0}, 10), 10)},
      kPlateVoxel, someHundred());
  double before = 0;
  for (const double t : {0.0, 0.4, 0.7, 1.0}) {
    const FloatGrid::Ptr frame = morph.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    double low = 1e9, high = 0;
    for (const Vec3d& p : surfacePoints(*frame))
      low = std::min(low, p.length()), high = std::max(high, p.length());
    EXPECT_LT(high - low, kPlateVoxel) << t;
    EXPECT_GT(low, before) << t;
    before = high;
    if (t == 0 || t == 1) {
      EXPECT_NEAR((low + high) / 2, 5 + 5 * t, 0.5 * kPlateVoxel) << t;
    }
  }
}

/// The published figure: two circles in one plane, one in the next. On the way the two join, once.
TEST(Variational, JoinsTwoBallsOnce) {
  const auto two = shapes::joined({shapes::sphere({-6, 0, 0}, 4), shapes::sphere({6, 0, 0}, 4)});
  const VariationalMorph morph({plateShape(two, 10), plateShape(shapes::sphere({0, 0, 0}, 6), 6)},
                               kPlateVoxel, someHundred());
  int before = 2;
  for (int i = 0; i <= 6; ++i) {
    const ShapeMeasures measures = measureShape(*morph.frame({1 - i / 6.0, i / 6.0}));
    EXPECT_EQ(measures.genus, 0) << i;
    EXPECT_LE(measures.pieces, before) << i;
    before = measures.pieces;
    if (i == 0) {
      EXPECT_EQ(before, 2);
    }
  }
  EXPECT_EQ(before, 1);
}

TEST(Variational, RefusesWhatItCannotTake) {
  const FloatGrid::ConstPtr ball = plateShape(shapes::sphere({0, 0, 0}, 5), 5);
  VariationalOptions many;
  many.points = 1500;
  EXPECT_NE(refusal([&] {
              VariationalMorph({ball, ball}, kPlateVoxel, many);
            }).find("6000; 5000 at most"),
            std::string::npos);
  EXPECT_NE(refusal([&] {
              VariationalMorph({ball, ball}, 0.05);
            }).find("10 billion at most"),
            std::string::npos);
  VariationalOptions few;
  few.points = 20;
  EXPECT_EQ(refusal([&] {
              VariationalMorph({ball, ball}, kPlateVoxel, few).frame({1});
            }),
            "1 weights for 2 objects");
}

TEST(Variational, IsCancelled) {
  class Stopped : public Progress {
    bool cancelled() const override { return true; }
  } stopped;
  EXPECT_THROW(VariationalMorph({plateShape(shapes::sphere({0, 0, 0}, 4), 4)}, kPlateVoxel, {}, &stopped),
               Cancelled);
}

TEST(Variational, DoesNotDependOnTheNumberOfThreads) {
  VariationalOptions few;
  few.points = 60;
  const FloatGrid::ConstPtr a = plateShape(shapes::sphere({0, 0, 0}, 4), 4),
                            b = plateShape(shapes::sphere({1, 0, 0}, 5), 6);
  expectSameForThreads([&] { return VariationalMorph({a, b}, kPlateVoxel, few).frame({0.4, 0.6}); });
}

}  // namespace
}  // namespace slicemorph
