#include "engine/peers/radial.h"

#include "slicemorph/errors.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kVoxel = 0.5;

Object starObject(const char* name, const shapes::Distance& distance, const Vec3d& centre = Vec3d(0.0)) {
  return {name, shapes::levelSet(distance, shapes::cube(centre, 16), kVoxel)};
}

/// Two balls of radius 8 that overlap, 3 above and below a centre: not convex, but star-shaped.
shapes::Distance snowman(const Vec3d& centre) {
  return shapes::joined(
      {shapes::sphere(centre + Vec3d(0, 0, 3), 8), shapes::sphere(centre - Vec3d(0, 0, 3), 8)});
}

/// Its radius in a direction of length 1: from |r d - 3 z| = 8.
double snowmanRadius(const Vec3d& d) {
  const double along = 3 * std::abs(d[2]);
  return along + std::sqrt(64 - 9 + along * along);
}

/// Each surface point's distance to `centre` less `radius(direction)`, the largest by its amount: of all points, and of
/// those away from the crease of the snowman.
struct RadiusError {
  double all = 0, smooth = 0;
};
template <typename Radius>
RadiusError radiusError(const FloatGrid& frame, const Vec3d& centre, const Radius& radius) {
  RadiusError error;
  for (const Vec3d& p : surfacePoints(frame)) {
    const double length = (p - centre).length();
    const double off = std::abs(length - radius((p - centre) / length));
    error.all = std::max(error.all, off);
    if (std::abs(p[2] - centre[2]) > 3 * kVoxel) error.smooth = std::max(error.smooth, off);
  }
  return error;
}

/// The radii of a ball and of a snowman that stands elsewhere are blended, and so are their centres. Facets and linear
/// values between voxels cut a sphere of radius 8 by h^2 / 8 / 8 = h / 128 each; to this come the two input level sets,
/// likewise, and the centres, which are found to a few hundredths of a node of the coarse grid (20 / 112): a tenth of a
/// voxel in all. On the crease a voxel's values are of both sides: half a voxel.
TEST(Radial, BlendsTheRadiiOfStarShapes) {
  const Vec3d there(6, -2, 1);
  const RadialMorph morph(
      {starObject("ball", shapes::sphere({0, 0, 0}, 10)), starObject("snowman", snowman(there), there)},
      kVoxel);
  for (const double t : {0.0, 0.25, 0.5, 1.0}) {
    const FloatGrid::Ptr frame = morph.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    const RadiusError error =
        radiusError(*frame, t * there, [&](const Vec3d& d) { return (1 - t) * 10 + t * snowmanRadius(d); });
    EXPECT_LT(error.smooth, 0.1 * kVoxel) << t;
    EXPECT_LT(error.all, 0.5 * kVoxel) << t;
  }
}

TEST(Radial, BlendsAnyNumberOfObjects) {
  const RadialMorph morph(
      {starObject("a", shapes::sphere({0, 0, 0}, 4)), starObject("b", shapes::sphere({0, 0, 0}, 8)),
       starObject("c", snowman({0, 0, 0}))},
      kVoxel);
  const RadiusError error = radiusError(*morph.frame({0.25, 0.25, 0.5}), Vec3d(0.0), [](const Vec3d& d) {
    return 0.25 * 4 + 0.25 * 8 + 0.5 * snowmanRadius(d);
  });
  EXPECT_LT(error.smooth, 0.1 * kVoxel);
}

/// Spheres about one centre have normals along their radii, so that the Hermite cubic is one of radii: with radii a, b
/// and tangents of length m = s (a + b) / 2, at t
/// (1 + 2 t) (1 - t)^2 a + t (1 - t)^2 m + t^2 (3 - 2 t) b - t^2 (1 - t) m.
TEST(Radial, FollowsHermiteCubicsAlongNormals) {
  RadialOptions options;
  options.tangent = 1;
  const double a = 5, b = 10, m = 7.5;
  const RadialMorph morph(
      {starObject("a", shapes::sphere({0, 0, 0}, a)), starObject("b", shapes::sphere({0, 0, 0}, b))}, kVoxel,
      options);
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const double s = 1 - t;
    const double expected = (1 + 2 * t) * s * s * a + t * s * s * m + t * t * (3 - 2 * t) * b - t * t * s * m;
    EXPECT_LT(radiusError(*morph.frame({s, t}), Vec3d(0.0), [&](const Vec3d&) { return expected; }).all,
              0.1 * kVoxel)
        << t;
  }
}

/// A thick L: its centroid does not see both legs whole, its corner does.
TEST(Radial, FindsACentreThatSeesAll) {
  const auto leg = shapes::box({10, 3, 3}, 1);
  const auto half = [&](const Mat3d& turn, const Vec3d& offset) { return shapes::placed(leg, turn, offset); };
  Mat3d quarter(0, -1, 0, 1, 0, 0, 0, 0, 1);
  const auto corner = shapes::joined({half(Mat3d::identity(), {7, 0, 0}), half(quarter, {0, 7, 0})});
  const Vec3d middle(5, 5, 0);
  EXPECT_NO_THROW(RadialMorph({{"L", shapes::levelSet(corner, shapes::cube(middle, 16), kVoxel)},
                               starObject("ball", shapes::sphere({0, 0, 0}, 8))},
                              kVoxel));
}

TEST(Radial, RefusesWhatItCannotTake) {
  const Object ball = starObject("ball", shapes::sphere({0, 0, 0}, 8));
  const Object ring = starObject("ring.obj", shapes::torus({0, 0, 0}, 8, 3));
  const std::string notStar = refusal([&] { RadialMorph({ball, ring}, kVoxel); });
  EXPECT_NE(notStar.find("'ring.obj' is not star-shaped"), std::string::npos) << notStar;
  const std::string tooMany = refusal([&] { RadialMorph({ball, ball}, 0.01); });
  EXPECT_NE(tooMany.find("8 million at most"), std::string::npos) << tooMany;
  RadialOptions curved;
  curved.tangent = 1;
  EXPECT_THROW(RadialMorph({ball, ball, ball}, kVoxel, curved), InputError);
  EXPECT_THROW(RadialMorph({ball, ball}, kVoxel).frame({1}), InputError);
}

TEST(Radial, IsTheSameForAnyNumberOfThreads) {
  expectSameForThreads([] {
    RadialOptions options;
    options.tangent = 0.5;
    return RadialMorph({starObject("ball", shapes::sphere({0, 0, 0}, 10)),
                        starObject("snowman", snowman({1, 2, 3}), {1, 2, 3})},
                       kVoxel, options)
        .frame({0.5, 0.5});
  });
}

}  // namespace
}  // namespace slicemorph
