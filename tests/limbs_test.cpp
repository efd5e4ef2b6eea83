// A body with limbs: capsules as a quadruped that walks. 128 voxels along the longest side.
#include "engine/measure/measure.h"
#include "engine/slicemorph.h"
#include "engine/spine/limbs.h"
#include "engine/volume/distance_field.h"
#include "engine/volume/voxelise.h"
#include "tests/section_parts.h"
#include "tests/shapes.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
using shapes::Distance;

Distance capsule(const Vec3d& a, const Vec3d& b, double radius) {
  return [=](const Vec3d& p) {
    const Vec3d ab = b - a;
    const double t = std::min(std::max((p - a).dot(ab) / ab.lengthSqr(), 0.0), 1.0);
    return (p - a - t * ab).length() - radius;
  };
}

constexpr double kLegLength = 0.62, kLegRadius = 0.065;

/// Body along x, legs down along -z from its four corners, neck, head and tail. `swing`: of each leg, degrees forwards.
/// `legs`: how many of them it has.
Distance quadruped(const std::array<double, 4>& swing, int legs = 4) {
  std::vector<Distance> parts{capsule({-0.55, 0, 0.45}, {0.5, 0, 0.45}, 0.17), capsule({0.5, 0, 0.5}, {0.78, 0, 0.85}, 0.09),
                              capsule({0.78, 0, 0.85}, {0.98, 0, 0.8}, 0.1), capsule({-0.6, 0, 0.5}, {-0.85, 0, 0.3}, 0.05)};
  for (int leg = 0; leg < legs; ++leg) {
    const Vec3d hip(leg < 2 ? 0.42 : -0.48, leg % 2 ? 0.13 : -0.13, 0.4);
    const double a = swing[size_t(leg)] * kPi / 180;
    parts.push_back(capsule(hip, hip + kLegLength * Vec3d(std::sin(a), 0, -std::cos(a)), kLegRadius));
  }
  return [=](const Vec3d& p) {
    double d = 1e30;
    for (const Distance& part : parts) d = std::min(d, part(p));
    return d;
  };
}

Object object(const Distance& distance) {
  const double h = 1.9 / 128;
  return {"quadruped", shapes::levelSet(distance, openvdb::BBoxd(Vec3d(-1.1, -0.4, -0.4), Vec3d(1.2, 0.4, 1.1)), h)};
}

/// Four legs, the neck with the head, and the tail; each tip within two nodes of the coarse grid (1.9 / 112 apart, and
/// the tip is a node) of the capsule's own.
TEST(Limbs, AllAreFoundWithTheirTips) {
  const DistanceField field(object(quadruped({30, -30, 0, 15})).levelSet);
  const std::vector<Limb> limbs = findLimbs(field);
  EXPECT_EQ(limbs.size(), 6u);
  std::vector<Vec3d> tips{{1.08, 0, 0.77}, {-0.89, 0, 0.27}};
  const double swing[4] = {30, -30, 0, 15};
  for (int leg = 0; leg < 4; ++leg) {
    const double a = swing[leg] * kPi / 180;
    tips.push_back(Vec3d(leg < 2 ? 0.42 : -0.48, leg % 2 ? 0.13 : -0.13, 0.4) +
                   0.685 * Vec3d(std::sin(a), 0, -std::cos(a)));
  }
  for (const Vec3d& tip : tips) {
    double nearest = 1e30;
    for (const Limb& limb : limbs) nearest = std::min(nearest, (limb.line.back() - tip).length());
    // A round end's farthest point may lie anywhere on its cap.
    EXPECT_LE(nearest, 2 * field.spacing() + 0.07) << tip;
  }
}

TEST(Limbs, ABallHasNone) {
  EXPECT_TRUE(findLimbs(DistanceField(shapes::levelSet(shapes::sphere({0, 0, 0}, 1), shapes::cube({0, 0, 0}, 1), 2.0 / 128))).empty());
}

TEST(Limbs, QuadrupedWalksOnFourLegs) {
  const Object standing = object(quadruped({0, 0, 0, 0})), walking = object(quadruped({30, -30, -30, 30}));
  const MorphPlan plan({standing, walking});
  const double volumeA = measureShape(*standing.levelSet).volume, volumeB = measureShape(*walking.levelSet).volume;
  for (int i = 0; i < 25; ++i) {
    const double t = i / 24.0;
    const FloatGrid::Ptr frame = plan.frame({1 - t, t}).surface;
    const ShapeMeasures m = measureShape(*frame);
    const double volume = m.volume / ((1 - t) * volumeA + t * volumeB);
    // Half way down the legs, and a third of a leg above the lowest feet.
    const int middle = sectionParts(*frame, 2, 0.1), low = sectionParts(*frame, 2, -0.1);
    std::printf("  t %.3f: pieces %d, genus %d, legs %d and %d, volume %.3f\n", t, m.pieces, m.genus, middle, low, volume);
    EXPECT_EQ(m.pieces, 1) << "t " << t;
    EXPECT_EQ(middle, 4) << "t " << t;
    EXPECT_EQ(low, 4) << "t " << t;
    EXPECT_GE(volume, 0.95) << "t " << t;
  }
}

/// A leg that only one object has grows out of the body: its foot comes down steadily, and it is never apart.
TEST(Limbs, ALegGrowsOutOfTheBody) {
  const Object three = object(quadruped({0, 0, 0, 0}, 3)), four = object(quadruped({0, 0, 0, 0}));
  const MorphPlan plan({three, four});
  const double h = four.levelSet->voxelSize()[0], belly = 0.45 - 0.17, foot = 0.4 - kLegLength - kLegRadius;
  double before = 0;
  for (int i = 0; i <= 12; ++i) {
    const double t = i / 12.0;
    const FloatGrid::Ptr frame = plan.frame({1 - t, t}).surface;
    const ShapeMeasures m = measureShape(*frame);
    // How far below the belly the fourth leg's corner of the body reaches.
    const Mesh mesh = surfaceOf(*frame);
    double lowest = belly;
    for (const auto& p : mesh.points)
      if (p[0] < -0.2 && p[1] > 0.04) lowest = std::min(lowest, double(p[2]));
    const double length = (belly - lowest) / (belly - foot);
    std::printf("  t %.3f: pieces %d, genus %d, leg %.3f of its length\n", t, m.pieces, m.genus, length);
    EXPECT_EQ(m.pieces, 1) << "t " << t;
    EXPECT_EQ(m.genus, 0) << "t " << t;
    // Its root lies below the surface: it shows a little later than at once, and then grows evenly.
    EXPECT_NEAR(length, t, 0.2) << "t " << t;
    EXPECT_GE(length, before - h) << "t " << t;
    before = length;
  }
}

}  // namespace
}  // namespace slicemorph
