// Rods with a bead each, the beads in different positions: which slices belong together is known.
#include "engine/match/along_spine.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

using shapes::Distance;

constexpr double kVoxel = 0.03;
const openvdb::BBoxd kBox(Vec3d(-1.2, -0.7, -0.7), Vec3d(1.2, 0.7, 0.7));
/// A slab is a 48th of the objects' length; the changes of the shifts are smoothed over 1.2 slabs.
constexpr double kSlab = 2.0 / 48;

/// Along x from -1 to 1, with a bead of length 0.4 about `bead`.
Distance beaded(double bead) {
  const Distance rod = shapes::box({1, 0.15, 0.15}, 0.04), ball = shapes::box({0.2, 0.5, 0.5}, 0.05);
  return shapes::joined({rod, shapes::placed(ball, Mat3d::identity(), {bead, 0, 0})});
}

/// The matched positions, and the equal ones without matching.
struct Matched {
  AlongSpine found;
  std::vector<double> equal;
};

Matched matched(const std::vector<Distance>& objects) {
  Fields fields;
  std::vector<Chart> charts(objects.size(), shapes::straightChart());
  std::vector<openvdb::BBoxd> boxes;
  for (const Distance& d : objects) {
    fields.push_back(shapes::fieldOf(d, kBox, kVoxel));
    boxes.push_back(fields.back()->box());
  }
  const SlicePlanes planes = placeSlices(boxes, 64);
  return {matchAlongSpine(fields, charts, planes), planes.z0};
}

void expectRising(const std::vector<double>& positions) {
  for (size_t i = 1; i < positions.size(); ++i) EXPECT_GT(positions[i], positions[i - 1]);
}

/// Beads half a unit apart: their slices meet in the middle, the first object's as far before it as the
/// second's behind it.
TEST(AlongSpine, BeadsMeetHalfWay) {
  const double first = -0.25, second = 0.25;
  const auto [found, z0] = matched({beaded(first), beaded(second)});
  EXPECT_LT(found.before, 0.75);
  EXPECT_GT(found.after, found.before + 0.1);
  for (size_t i = 0; i < z0.size(); ++i) {
    EXPECT_NEAR(found.position[0][i] + found.position[1][i], 2 * z0[i], 0.1 * kSlab) << i;
    if (std::abs(z0[i]) < 0.2 - 1.5 * kSlab) {
      EXPECT_NEAR(found.position[0][i], z0[i] + first, kSlab) << i;
      EXPECT_NEAR(found.position[1][i], z0[i] + second, kSlab) << i;
    }
  }
  expectRising(found.position[0]);
  expectRising(found.position[1]);
}

TEST(AlongSpine, TheOtherWayRoundIsTheSame) {
  const AlongSpine ab = matched({beaded(-0.2), beaded(0.15)}).found,
                   ba = matched({beaded(0.15), beaded(-0.2)}).found;
  for (size_t i = 0; i < ab.position[0].size(); ++i) {
    EXPECT_NEAR(ab.position[0][i], ba.position[1][i], kSlab) << i;
    EXPECT_NEAR(ab.position[1][i], ba.position[0][i], kSlab) << i;
  }
}

TEST(AlongSpine, LikeObjectsStayInPlace) {
  const auto [found, z0] = matched({beaded(0.1), beaded(0.1), beaded(0.1)});
  for (const std::vector<double>& position : found.position) EXPECT_EQ(position, z0);
  EXPECT_NEAR(found.before, 1, 1e-6);
}

/// The slices of a plate on its edge overlap little with those of a plate lying flat, however
/// they are shifted.
TEST(AlongSpine, UnlikeSlicesStayInPlace) {
  const auto plate = [](bool lies, double bead) {
    const Distance flat = lies ? shapes::box({1, 0.6, 0.06}, 0.02) : shapes::box({1, 0.06, 0.6}, 0.02);
    const Distance block = lies ? shapes::box({0.2, 0.6, 0.12}, 0.02) : shapes::box({0.2, 0.12, 0.6}, 0.02);
    return shapes::joined({flat, shapes::placed(block, Mat3d::identity(), {bead, 0, 0})});
  };
  const auto [found, z0] = matched({plate(true, -0.25), plate(false, 0.25)});
  EXPECT_LT(found.after, 0.35);
  for (const std::vector<double>& position : found.position) EXPECT_EQ(position, z0);
}

/// Beads further apart than half the length are not matched: no slice moves by more than a
/// third of the length.
TEST(AlongSpine, NothingMovesFurtherThanAThird) {
  const auto [found, z0] = matched({beaded(-0.7), beaded(0.7)});
  for (const std::vector<double>& position : found.position)
    for (size_t i = 0; i < position.size(); ++i)
      EXPECT_LE(std::abs(position[i] - z0[i]), 2.0 / 3 + 0.1 * kSlab) << i;
}

}  // namespace
}  // namespace slicemorph
