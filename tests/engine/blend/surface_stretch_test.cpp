// How a plan judges its own maps, where the maps are known.
#include "engine/blend/surface_stretch.h"

#include "slicemorph/slicemorph.h"
#include "tests/support/shapes.h"

#include <gtest/gtest.h>

namespace slicemorph {
namespace {

constexpr double kStretchVoxel = 0.04;

Object egg(const char* name, double scale, const Mat3d& turn = Mat3d::identity()) {
  const shapes::Distance own =
      shapes::joined({shapes::sphere({0.3, 0, 0}, 0.7), shapes::sphere({-0.5, 0.2, 0}, 0.5),
                      shapes::box({0.9, 0.3, 0.5}, 0.15)});
  const double reach = 1.3 * scale;
  return {name, shapes::levelSet(shapes::placed(own, turn, {1, 2, 3}, scale),
                                 {Vec3d(1, 2, 3) - Vec3d(reach), Vec3d(1, 2, 3) + Vec3d(reach)},
                                 scale * kStretchVoxel)};
}

/// A shape twice as large is not stretched: what changes is its size. The matching slides points along the surface by some
/// hundredths of its cells, which are 0.1 here: a tenth of stretch at most.
TEST(SurfaceStretch, OfSizeAloneIsNone) {
  const MorphPlan plan({egg("a", 1), egg("b", 2)});
  for (double t : {0.0, 0.5, 1.0}) {
    const FrameStrain s = plan.strain({1 - t, t});
    EXPECT_GE(s.meanStretch, 1) << t;
    EXPECT_LT(s.meanStretch, 1.1) << t;
    EXPECT_LT(s.worstStretch, 2) << t;
    EXPECT_EQ(s.muchStretched, 0) << t;
    EXPECT_LT(s.meanTurn, 0.05) << t;
  }
  EXPECT_GT(plan.overlap(), 0.97);
}

/// A rod that becomes four times as long at the same thickness is stretched by 4 along and 1 around: against the mean
/// size, 2, that is 2 both ways; half way 2.5 and 1 make the root of 2.5. Its round ends are stretched less.
TEST(SurfaceStretch, OfARodThatGrows) {
  const auto rod = [](const char* name, double half) {
    return Object{
        name, shapes::levelSet(shapes::capsule({-half, 0, 0}, {half, 0, 0}, 0.2),
                               {Vec3d(-half - 0.2, -0.2, -0.2), Vec3d(half + 0.2, 0.2, 0.2)}, kStretchVoxel)};
  };
  const MorphPlan plan({rod("short", 0.6), rod("long", 2.4)});
  const double whole = plan.strain({0, 1}).meanStretch, half = plan.strain({0.5, 0.5}).meanStretch;
  // These frames are the objects themselves; a map's inverse is found to a hundredth of the step over which it is differentiated.
  EXPECT_NEAR(plan.strain({1, 0}).meanStretch, 1, 0.01);
  EXPECT_NEAR(whole, 1, 0.01);
  EXPECT_GT(half, 1.2);
  EXPECT_LT(half, 1.7);
  EXPECT_EQ(plan.strain({0.5, 0.5}).muchStretched, 0);
}

}  // namespace
}  // namespace slicemorph
