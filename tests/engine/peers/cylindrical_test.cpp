#include "engine/peers/cylindrical.h"

#include "slicemorph/errors.h"
#include "tests/support/frame_points.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kRodVoxel = 0.5;
constexpr double kRodHalf = 18;  ///< half the axis between the round ends' centres

/// A rod with round ends whose axis is an arc of `degrees` in the plane of x and y, 2 kRodHalf long; the mean of the axis'
/// points is the origin, where it is parallel to x.
shapes::Distance bentRod(double degrees, double radius) {
  const double half = degrees * openvdb::math::pi<double>() / 360;
  if (half == 0) return shapes::capsule({-kRodHalf, 0, 0}, {kRodHalf, 0, 0}, radius);
  const double bend = kRodHalf / half;
  const Vec3d centre(0, bend * std::sin(half) / half, 0);
  return [=](const Vec3d& p) {
    const Vec3d q = p - centre;
    const double angle = std::min(std::max(std::atan2(q[0], -q[1]), -half), half);
    return (q - bend * Vec3d(std::sin(angle), -std::cos(angle), 0)).length() - radius;
  };
}

Object rodObject(const char* name, const shapes::Distance& distance) {
  return {name, shapes::levelSet(distance, shapes::cube(Vec3d(0.0), 28), kRodVoxel)};
}

double farthestFromRod(const FloatGrid& frame, const shapes::Distance& shape) {
  double farthest = 0;
  for (const Vec3d& p : surfacePoints(frame)) farthest = std::max(farthest, std::abs(shape(p)));
  return farthest;
}

/// A straight rod becomes a bent and thicker one by bends, lengths and radii in between. The spines are found from
/// slices of voxels and are trusted to a quarter of a voxel each, where they enter the round ends, whose slices are askew.
TEST(Cylindrical, BendsARod) {
  const CylindricalMorph morph({rodObject("straight", bentRod(0, 4)), rodObject("bent", bentRod(80, 5))},
                               kRodVoxel);
  for (const double t : {0.0, 0.25, 0.5, 0.75, 1.0}) {
    const FloatGrid::Ptr frame = morph.frame({1 - t, t});
    EXPECT_EQ(frame->getName(), "surface");
    const double off = farthestFromRod(*frame, bentRod(80 * t, 4 + t));
    std::printf("  t %.2f: %.3f voxels\n", t, off / kRodVoxel);
    EXPECT_LT(off, kRodVoxel / 2) << t;
  }
}

TEST(Cylindrical, BlendsManyObjectsAndTakesCaps) {
  CylindricalOptions options;
  options.cap = 0.3;
  const CylindricalMorph morph(
      {rodObject("a", bentRod(0, 3)), rodObject("b", bentRod(0, 4)), rodObject("c", bentRod(0, 5))},
      kRodVoxel, options);
  const double off = farthestFromRod(*morph.frame({0.25, 0.5, 0.25}), bentRod(0, 4));
  std::printf("  %.3f voxels\n", off / kRodVoxel);
  EXPECT_LT(off, kRodVoxel / 2);
}

/// Balls have no spine: their axes are straight.
TEST(Cylindrical, TakesWhatIsAsWideAsLong) {
  const CylindricalMorph morph(
      {rodObject("a", shapes::sphere({0, 0, 0}, 6)), rodObject("b", shapes::sphere({0, 0, 0}, 10))},
      kRodVoxel);
  const double off = farthestFromRod(*morph.frame({0.5, 0.5}), shapes::sphere(Vec3d(0.0), 8));
  std::printf("  %.3f voxels\n", off / kRodVoxel);
  EXPECT_LT(off, kRodVoxel / 2);
}

TEST(Cylindrical, RefusesWhatItCannotTake) {
  const Object rod = rodObject("rod", bentRod(0, 4));
  const auto refusalOf = [&](const Object& other) {
    return refusal([&] { CylindricalMorph({rod, other}, kRodVoxel); });
  };
  // A rod with a ring about it that does not touch it: rays from the axis leave both.
  const auto lips = shapes::joined({bentRod(0, 3), shapes::torus({0, 0, 0}, 7, 1.5)});
  const auto turned = shapes::placed(lips, Mat3d(0.0, 0.0, 1.0, 0.0, 1.0, 0.0, -1.0, 0.0, 0.0), Vec3d(0.0));
  const std::string twice = refusalOf(rodObject("ring.obj", turned));
  EXPECT_NE(twice.find("'ring.obj' is not star-shaped about its axis"), std::string::npos) << twice;
  const std::string tooMany = refusal([&] { CylindricalMorph({rod, rod}, 0.01); });
  EXPECT_NE(tooMany.find("at most"), std::string::npos) << tooMany;
  CylindricalOptions options;
  options.cap = 1;
  const std::string caps = refusal([&] { CylindricalMorph({rod, rod}, kRodVoxel, options); });
  EXPECT_NE(caps.find("cap is 1"), std::string::npos) << caps;
  EXPECT_THROW(CylindricalMorph({rod, rod}, kRodVoxel).frame({1}), InputError);
}

TEST(Cylindrical, IsTheSameForAnyNumberOfThreads) {
  expectSameForThreads(
      [] {
        return CylindricalMorph({rodObject("a", bentRod(0, 4)), rodObject("b", bentRod(60, 4))}, kRodVoxel)
            .frame({0.5, 0.5});
      },
      {4});
}

}  // namespace
}  // namespace slicemorph
