// A body with limbs: capsules as a quadruped that walks. 128 voxels along the longest side.
#include "engine/spine/limbs.h"
#include "engine/measure/measure.h"
#include "engine/volume/distance_field.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/slicemorph.h"
#include "tests/support/all_tests.h"
#include "tests/support/quadruped.h"
#include "tests/support/same_values.h"
#include "tests/support/section_parts.h"
#include "tests/support/shapes.h"
#include "tests/support/with_threads.h"

#include <gtest/gtest.h>

#include <array>
#include <cstdio>

namespace slicemorph {
namespace {

constexpr double kPi = 3.14159265358979323846;
using shapes::capsule;
using shapes::Distance;
using shapes::joined;

using shapes::quadruped;
using shapes::Quadruped;

Object object(const Distance& distance, int voxels = 128) {
  const double h = 1.9 / voxels;
  return {"quadruped", shapes::levelSet(distance, shapes::quadrupedBox(), h)};
}

/// Four legs, the neck with the head, and the tail; each tip within two nodes of the coarse grid (1.9 / 112
/// apart, and the tip is a node) of the capsule's own.
TEST(Limbs, AllAreFoundWithTheirTips) {
  const DistanceField field(object(quadruped({30, -30, 0, 15})).levelSet);
  const std::vector<Limb> limbs = findLimbs(field);
  EXPECT_EQ(limbs.size(), 6u);
  std::vector<Vec3d> tips{{1.08, 0, 0.77}, {-0.89, 0, 0.27}};
  const double swing[4] = {30, -30, 0, 15};
  for (int leg = 0; leg < 4; ++leg)
    tips.push_back(Quadruped::onLeg(leg, swing[leg], 1) +
                   Quadruped::kLegRadius * Quadruped::down(swing[leg]));
  for (const Vec3d& tip : tips) {
    double nearest = 1e30;
    for (const Limb& limb : limbs) nearest = std::min(nearest, (limb.line.back() - tip).length());
    // A round end's farthest point may lie anywhere on its cap.
    EXPECT_LE(nearest, 2 * field.spacing() + 0.07) << tip;
  }
}

TEST(Limbs, ABallHasNone) {
  EXPECT_TRUE(findLimbs(DistanceField(shapes::levelSet(shapes::sphere({0, 0, 0}, 1),
                                                       shapes::cube({0, 0, 0}, 1), 2.0 / 128)))
                  .empty());
}

TEST(Limbs, QuadrupedWalksOnFourLegs) {
  const Object standing = object(quadruped({0, 0, 0, 0})), walking = object(quadruped({30, -30, -30, 30}));
  const MorphPlan plan({standing, walking});
  const double volumeA = measureShape(*standing.levelSet).volume,
               volumeB = measureShape(*walking.levelSet).volume;
  const int last = allTests() ? 24 : 8;
  for (int i = 0; i <= last; ++i) {
    const double t = double(i) / last;
    const FloatGrid::Ptr frame = plan.frame({1 - t, t}).surface;
    const ShapeMeasures m = measureShape(*frame);
    const double volume = m.volume / ((1 - t) * volumeA + t * volumeB);
    // Half way down the legs, and a third of a leg above the lowest feet.
    const int middle = sectionParts(*frame, 2, 0.1), low = sectionParts(*frame, 2, -0.1);
    std::printf("  t %.3f: pieces %d, genus %d, legs %d and %d, volume %.3f\n", t, m.pieces, m.genus, middle,
                low, volume);
    EXPECT_EQ(m.pieces, 1) << "t " << t;
    EXPECT_EQ(middle, 4) << "t " << t;
    EXPECT_EQ(low, 4) << "t " << t;
    EXPECT_GE(volume, 0.95) << "t " << t;
  }
}

/// A leg that only one object has grows out of the body: its foot moves down steadily, and it
/// never comes off.
TEST(Limbs, ALegGrowsOutOfTheBody) {
  const Object three = object(quadruped({0, 0, 0, 0}, 3)), four = object(quadruped({0, 0, 0, 0}));
  const MorphPlan plan({three, four});
  const double h = four.levelSet->voxelSize()[0], belly = 0.45 - 0.17,
               foot = 0.4 - Quadruped::kLegLength - Quadruped::kLegRadius;
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
    // The stub lies below the surface, so the leg appears a little after the first frame, and
    // then grows evenly.
    EXPECT_NEAR(length, t, 0.2) << "t " << t;
    EXPECT_GE(length, before - h) << "t " << t;
    before = length;
  }
}

Object alongX(const Distance& distance, double voxel = 2.4 / 128) {
  return {"shape",
          shapes::levelSet(distance, openvdb::BBoxd(Vec3d(-1.6, -1.2, -1.2), Vec3d(1.9, 1.2, 1.2)), voxel)};
}

/// Heads correspond although one neck is six times as long as the other: half way both body and head keep
/// their shapes, and the neck has the mean length. Matching slices at equal positions grows the head out of
/// the neck: an error of 4.6 voxels, 0.63 in the mean. The tolerance is the rounding where the neck's ends
/// are stretched least and most within one slice's thickness (1.4 voxels) on either side.
TEST(Limbs, AHeadMeetsAHeadOnANeckOfAnotherLength) {
  const auto necked = [](double neck) {
    return joined({capsule({-1, 0, 0}, {-0.4, 0, 0}, 0.3), capsule({-0.4, 0, 0}, {neck, 0, 0}, 0.09),
                   capsule({neck - 0.1, 0, 0}, {neck + 0.05, 0, 0}, 0.24)});
  };
  const FloatGrid::Ptr frame =
      MorphPlan({alongX(necked(0.4)), alongX(necked(1.2))}).frame({0.5, 0.5}).surface;
  const Mesh mesh = surfaceOf(*frame);
  Mesh truth = surfaceOf(*alongX(necked(0.8)).levelSet);
  const auto middleOf = [](const Mesh& m) {
    openvdb::BBoxd box;
    for (const auto& p : m.points) box.expand(Vec3d(p));
    return box.getCenter();
  };
  const Vec3d shift = middleOf(mesh) - middleOf(truth);
  for (auto& p : truth.points) p += openvdb::Vec3s(shift);
  const SurfaceDistance d = surfaceDistance(mesh, truth);
  const double h = frame->voxelSize()[0];
  std::printf("  half way: mean %.3f, max %.3f voxels\n", d.mean / h, d.max / h);
  EXPECT_LE(d.mean / h, 0.5);
  EXPECT_LE(d.max / h, 2.8);
}

/// One branch becomes several, or several become more: nothing tears off and no handle appears; near the tips
/// there are as many branches as at the end with more of them, once they can be distinguished, and no more.
TEST(Limbs, OneBranchBecomesSeveral) {
  const auto fork = [](int prongs) {
    std::vector<Distance> parts{capsule({-1, 0, 0}, {0, 0, 0}, 0.25)};
    for (int i = 0; i < prongs; ++i) {
      const double y = prongs == 1 ? 0 : 0.5 * (2.0 * i / (prongs - 1) - 1);
      parts.push_back(capsule({0, 0.5 * y, 0}, {0.9, y, 0}, prongs == 1 ? 0.2 : 0.11));
    }
    return joined(parts);
  };
  for (const auto& [from, to] : {std::pair(1, 2), std::pair(1, 3), std::pair(2, 3)}) {
    const double voxel = 2.4 / (allTests() ? 128 : 88);  // a prong is eight voxels wide
    const Object a = alongX(fork(from), voxel), b = alongX(fork(to), voxel);
    const MorphPlan plan({a, b});
    const double volumeA = measureShape(*a.levelSet).volume, volumeB = measureShape(*b.levelSet).volume;
    const int last = allTests() ? 8 : 5;
    for (int i = 0; i <= last; ++i) {
      const double t = double(i) / last;
      const FloatGrid::Ptr frame = plan.frame({1 - t, t}).surface;
      const ShapeMeasures m = measureShape(*frame);
      int prongs = 0;
      for (double x = 0.4; x < 0.8; x += 0.05) prongs = std::max(prongs, sectionParts(*frame, 0, x));
      const double volume = m.volume / ((1 - t) * volumeA + t * volumeB);
      std::printf("  %d to %d, t %.3f: pieces %d, genus %d, prongs %d, volume %.3f\n", from, to, t, m.pieces,
                  m.genus, prongs, volume);
      EXPECT_EQ(m.pieces, 1) << "t " << t;
      // Known limit: between three prongs slits open in the middle before they reach the tips.
      EXPECT_LE(m.genus, to - from > 1 ? to - from : 0) << "t " << t;
      EXPECT_GE(prongs, t < 0.5 ? from : to) << "t " << t;
      // Known limit: one branch that becomes two retracts between them instead of splitting.
      EXPECT_LE(prongs, to == 2 ? from + to : to) << "t " << t;
      EXPECT_GE(volume, 0.95) << "t " << t;
    }
  }
}

TEST(Limbs, ThreadsDoNotChangeAValue) {
  const Object standing = object(quadruped({0, 0, 0, 0}), 72),
               walking = object(quadruped({30, -30, -30, 30}), 72);
  FloatGrid::Ptr first;
  for (size_t threads : {1, 4})
    withThreads(threads, [&] {
      const FloatGrid::Ptr frame = MorphPlan({standing, walking}).frame({0.6, 0.4}).surface;
      if (!first) first = frame;
      EXPECT_TRUE(sameValues(*frame, *first)) << threads << " threads";
    });
}

}  // namespace
}  // namespace slicemorph
