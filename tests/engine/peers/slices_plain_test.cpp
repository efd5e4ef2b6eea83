#include "engine/peers/slices_plain.h"

#include "slicemorph/errors.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kPlainVoxel = 0.5;

Object plainObject(const shapes::Distance& distance) {
  return {"object", shapes::levelSet(distance, shapes::cube(Vec3d(0.0), 18), kPlainVoxel)};
}

double farthestFromShape(const FloatGrid& frame, const shapes::Distance& shape) {
  double farthest = 0;
  for (const Vec3d& p : surfacePoints(frame)) farthest = std::max(farthest, std::abs(shape(p)));
  return farthest;
}

Mat3d turnAboutZ(double degrees) {
  const double a = degrees * openvdb::math::pi<double>() / 180, c = std::cos(a), s = std::sin(a);
  return Mat3d(c, -s, 0.0, s, c, 0.0, 0.0, 0.0, 1.0);
}

/// Balls: radii and centres are blended. The corner of the last flat slab is half its thickness off the ball; a tenth of a
/// voxel for what pixels and voxels cut.
TEST(SlicesPlain, BlendsBalls) {
  const PlainSlices morph(
      {plainObject(shapes::sphere({-4, 0, 0}, 6)), plainObject(shapes::sphere({5, 2, 1}, 10))}, kPlainVoxel);
  for (const double t : {0.0, 0.5, 1.0}) {
    const double radius = 6 + 4 * t;
    const FloatGrid::Ptr frame = morph.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    const Vec3d centre = (1 - t) * Vec3d(-4, 0, 0) + t * Vec3d(5, 2, 1);
    EXPECT_LT(farthestFromShape(*frame, shapes::sphere(centre, radius)), radius / 96 + 0.1 * kPlainVoxel)
        << t;
  }
}

/// A bar that is turned by 60 degrees turns as a whole: its box is turned, and slices stay what they are. Points lie on
/// rays 360 / 128 degrees apart, at most 5 from the axis; chords between them cut the corners, which are rounded with a
/// radius of 1, by less than half of the arc of 0.25 between two rays. Ends are closed by flat slabs 20 / 96 thick, half of
/// which they may be off.
TEST(SlicesPlain, TurnsABar) {
  const auto bar = shapes::box({10, 4, 2.5}, 1);
  const PlainSlices morph({plainObject(bar), plainObject(shapes::placed(bar, turnAboutZ(60), Vec3d(0.0)))},
                          kPlainVoxel);
  for (const double t : {0.0, 0.5, 1.0}) {
    const auto expected = shapes::placed(bar, turnAboutZ(60 * t), Vec3d(0.0));
    EXPECT_LT(farthestFromShape(*morph.frame({1 - t, t}), expected), 0.125 + 10.0 / 96 + 0.1 * kPlainVoxel)
        << t;
  }
}

/// Across the longest axis, x, slices of three rods side by side hold three contours each.
TEST(SlicesPlain, BlendsManyPartsOfManyObjects) {
  const auto rods = [](double radius) {
    std::vector<shapes::Distance> parts;
    for (const double y : {-6, 0, 6}) parts.push_back(shapes::capsule({-9, y, 0}, {9, y, 0}, radius));
    return shapes::joined(parts);
  };
  const PlainSlices morph({plainObject(rods(1)), plainObject(rods(2)), plainObject(rods(2.4))}, kPlainVoxel);
  // Heights differ by the ends' radii, so that slices at equal shares lie differently within the round ends: away from
  // them the rods have the mean radius, 1.8. Linear values between voxels and chords cut a circle of radius r by
  // h^2 / 8 / r: on each rod twice, where it is sampled and where it is traced, and on the result twice.
  double farthest = 0;
  for (const Vec3d& p : surfacePoints(*morph.frame({1.0 / 3, 1.0 / 3, 1.0 / 3})))
    if (std::abs(p[0]) < 7) farthest = std::max(farthest, std::abs(rods(1.8)(p)));
  EXPECT_GT(farthest, 0);
  const double cut = kPlainVoxel * kPlainVoxel / 8;
  EXPECT_LT(farthest, 2 * cut * ((1 / 1.0 + 1 / 2.0 + 1 / 2.4) / 3 + 1 / 1.8));
}

TEST(SlicesPlain, RefusesWhatItCannotTake) {
  const std::vector<Object> balls(2, plainObject(shapes::sphere({0, 0, 0}, 6)));
  PlainSlicesOptions options;
  options.samples = 3;
  EXPECT_NE(refusal([&] { PlainSlices(balls, kPlainVoxel, options); }).find("samples 3"), std::string::npos);
  EXPECT_NE(refusal([&] { PlainSlices(balls, 1e-4); }).find("at most"), std::string::npos);
  EXPECT_THROW(PlainSlices(balls, kPlainVoxel).frame({1}), InputError);
}

TEST(SlicesPlain, IsTheSameForAnyNumberOfThreads) {
  expectSameForThreads([] {
    return PlainSlices({plainObject(shapes::sphere({0, 0, 0}, 5)), plainObject(shapes::box({10, 4, 2.5}, 1))},
                       kPlainVoxel)
        .frame({0.5, 0.5});
  });
}

}  // namespace
}  // namespace slicemorph
