// Points deep inside thin parts, on rods whose axes are known.
#include "engine/match/core_points.h"

#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kCoreVoxel = 0.02, kRodRadius = 0.05;

/// A ball with a rod along x, which is at y = `aside`.
std::shared_ptr<const DistanceField> ballAndRod(double aside) {
  return shapes::fieldOf(shapes::joined({shapes::sphere({-1.6, 0, 0}, 0.6),
                                         shapes::capsule({-1.5, aside, 0}, {1, aside, 0}, kRodRadius)}),
                         openvdb::BBoxd({-2.3, -0.7, -0.7}, {1.2, 0.7, 0.7}), kCoreVoxel);
}

/// Rods that lie beside each other without touching meet axis on axis, half way between their axes, at the same length
/// along them: to within a coarse node, as nodes are what is deep or not.
TEST(CorePoints, OfRodsLieOnTheOthersAxis) {
  const double aside = 0.12;
  const MatchObjects objects =
      measureObjects({ballAndRod(0), ballAndRod(aside)}, {}, std::vector<Chart>(2), {});
  Matching matching;
  matching.map.lattice = objects.lattice(0.1);
  matching.map.of.assign(2, VectorField(matching.map.lattice.count(), openvdb::Vec3s(0.f)));
  const double node = objects.shape.fields[0]->spacing();
  size_t found = 0;
  for (const Correspondence& c : corePoints(objects, matching, 0.3)) {
    if (c.middle[0] < -0.8 || c.middle[0] > 0.9) continue;
    EXPECT_LE(Vec3d(0, c.at[0][1], c.at[0][2]).length(), node) << c.at[0];
    EXPECT_LE(Vec3d(0, c.at[1][1] - aside, c.at[1][2]).length(), node) << c.at[1];
    EXPECT_NEAR(c.at[0][0], c.at[1][0], node);
    EXPECT_LE((c.middle - 0.5 * (c.at[0] + c.at[1])).length(), 1e-6);
    EXPECT_FLOAT_EQ(c.weight, 1);
    ++found;
  }
  // From either at least one a coarse node along the axis.
  EXPECT_GT(double(found), 2 * 1.7 / node - 2);
}

TEST(CorePoints, BeyondTheReachThereAreNone) {
  const MatchObjects objects =
      measureObjects({ballAndRod(0), ballAndRod(0.3)}, {}, std::vector<Chart>(2), {});
  Matching matching;
  matching.map.lattice = objects.lattice(0.1);
  matching.map.of.assign(2, VectorField(matching.map.lattice.count(), openvdb::Vec3s(0.f)));
  for (const Correspondence& c : corePoints(objects, matching, 0.2)) EXPECT_LT(c.middle[0], -0.8);
}

}  // namespace
}  // namespace slicemorph
