// Two concentric balls of different radii: the positions of equal depth are known.
#include "engine/rebuild/match_depths.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>

namespace slicemorph {
namespace {

constexpr double kVoxel = 0.05;

/// Balls of radius 1 and 1.2, each of weight 0.5, that the map aligns without displacement.
class MatchDepthsOfBalls : public testing::Test {
 protected:
  void SetUp() override {
    for (double radius : {1.0, 1.2}) {
      fields.push_back(
          shapes::fieldOf(shapes::sphere({0, 0, 0}, radius), shapes::cube({0, 0, 0}, 1.4), kVoxel));
      CarriedImage carried;
      carried.shape = images.size(), carried.weight = 0.5, carried.field = fields.back().get();
      carried.anchor = fields.back()->anchor();
      images.push_back(carried);
    }
    nodes.map.step = 1, nodes.map.objects = 2, nodes.map.origin = openvdb::Coord(-9),
    nodes.map.size = openvdb::Coord(19);
    for (auto c = openvdb::CoordBBox(openvdb::Coord(-9), openvdb::Coord(9)).begin(); c; ++c)
      nodes.map.known.push_back(1);
    nodes.map.at.resize(2 * nodes.map.known.size());
    for (auto c = openvdb::CoordBBox(openvdb::Coord(-9), openvdb::Coord(9)).begin(); c; ++c)
      for (size_t k = 0; k < 2; ++k)
        nodes.map.at[2 * nodes.map.index((*c)[0], (*c)[1], (*c)[2]) + k] =
            openvdb::Vec3s(kSpacing * (*c).asVec3d() - images[k].anchor);
  }
  std::vector<MatchDepths::Position> positionsAt(const Vec3d& p) const {
    std::vector<MatchDepths::Position> positions(2);
    for (size_t k = 0; k < 2; ++k) positions[k].at = openvdb::Vec3s(p - images[k].anchor);
    return positions;
  }
  static constexpr double kSpacing = 0.2;
  Fields fields;
  std::vector<CarriedImage> images;
  ImageNodes nodes;
};

/// The in-between is a ball of radius 1.1. On its surface every image is sampled on its own object's surface,
/// in the same direction.
TEST_F(MatchDepthsOfBalls, OnTheSurfaceAllAreOnTheirOwn) {
  const MatchDepths depths(images, nodes);
  for (const Vec3d& direction : {Vec3d(1, 0, 0), Vec3d(0.6, 0, -0.8), Vec3d(1, 2, 3).unit()}) {
    auto positions = positionsAt(1.1 * direction);
    depths.measure(positions);
    EXPECT_NEAR(positions[0].distance, 0.1, 0.1 * kVoxel);
    EXPECT_NEAR(positions[1].distance, -0.1, 0.1 * kVoxel);
    EXPECT_NEAR(depths.match(positions).distance, 0, 0.1 * kVoxel);
    for (size_t k = 0; k < 2; ++k) {
      const Vec3d at = Vec3d(positions[k].at) + images[k].anchor;
      // The nearest surface point is exact to about a voxel along the surface.
      EXPECT_NEAR(at.length(), k == 0 ? 1 : 1.2, 0.2 * kVoxel) << direction;
      EXPECT_LE((at - at.length() * direction).length(), 1.5 * kVoxel) << direction;
    }
  }
}

/// On the surface both are shifted by the radii's difference to the mean, far from it neither.
TEST_F(MatchDepthsOfBalls, ShiftsAreTold) {
  const MatchDepths depths(images, nodes);
  for (double r : {0.5, 1.1, 1.7}) {
    auto positions = positionsAt({0, r, 0});
    depths.measure(positions);
    EXPECT_NEAR(depths.match(positions).shift, r == 1.1 ? 0.1 : 0, 0.1 * kVoxel) << r;
  }
}

/// Half a voxel inside, every image is sampled half a voxel inside; far from the surface nothing moves.
TEST_F(MatchDepthsOfBalls, DepthsAreThoseOfTheInBetween) {
  const MatchDepths depths(images, nodes);
  auto positions = positionsAt({0, 1.1 - 0.5 * kVoxel, 0});
  depths.measure(positions);
  EXPECT_NEAR(depths.match(positions).distance, -0.5 * kVoxel, 0.1 * kVoxel);
  depths.measure(positions);
  for (const auto& position : positions) EXPECT_NEAR(position.distance, -0.5 * kVoxel, 0.2 * kVoxel);
  for (double r : {0.5, 1.7}) {
    auto far = positionsAt({r, 0, 0});
    const auto before = far;
    depths.measure(far);
    EXPECT_NEAR(depths.match(far).distance, r - 1.1, 0.2 * kVoxel);
    for (size_t k = 0; k < 2; ++k) EXPECT_EQ(far[k].at, before[k].at);
  }
}

/// Matching fades with depth and ends at three voxels: at three quarters of that it is half. The moves are
/// short there and follow the gradient.
TEST_F(MatchDepthsOfBalls, MatchingFadesWithDepth) {
  const MatchDepths depths(images, nodes);
  const double blended = -0.75 * kHalfWidth * kVoxel;
  auto positions = positionsAt({0, 0, 1.1 + blended});
  depths.measure(positions);
  const auto before = positions;
  EXPECT_NEAR(depths.match(positions).distance, blended, 0.1 * kVoxel);
  depths.measure(positions);
  for (size_t k = 0; k < 2; ++k)
    EXPECT_NEAR(positions[k].distance, before[k].distance + 0.5 * (blended - before[k].distance),
                0.15 * kVoxel)
        << k;
}

/// Between the two surfaces one image would show its inside although the in-between is outside; it
/// is sampled outside.
TEST_F(MatchDepthsOfBalls, NothingIsSeenFromTheOtherSide) {
  const MatchDepths depths(images, nodes);
  for (double r : {1.03, 1.07, 1.13, 1.17}) {
    auto positions = positionsAt({r, 0, 0});
    depths.measure(positions);
    const float blended = depths.match(positions).distance;
    depths.measure(positions);
    for (const auto& position : positions) EXPECT_EQ(position.distance < 0, blended < 0) << r;
  }
}

/// No cell through which a surface passes may be missed.
TEST_F(MatchDepthsOfBalls, CellsNearASurfaceAreFound) {
  const MatchDepths depths(images, nodes);
  size_t far = 0;
  for (auto c = openvdb::CoordBBox(openvdb::Coord(-9), openvdb::Coord(8)).begin(); c; ++c) {
    double low = 1e30, high = 0;
    for (int n = 0; n < 8; ++n) {
      const double r = kSpacing * (*c).offsetBy(n & 1, n >> 1 & 1, n >> 2).asVec3d().length();
      low = std::min(low, r), high = std::max(high, r);
    }
    if (low < 1.2 && high > 1) {
      EXPECT_TRUE(depths.near(*c)) << *c;
    }
    far += !depths.near(*c);
  }
  EXPECT_GT(far, 100u);
}

TEST_F(MatchDepthsOfBalls, LinesThroughASurfaceAreNearIt) {
  const MatchDepths depths(images, nodes);
  const auto near = [&](double from, double to) {
    auto first = positionsAt({from, 0, 0}), last = positionsAt({to, 0, 0});
    depths.measure(first), depths.measure(last);
    return depths.near(first, last);
  };
  EXPECT_TRUE(near(0.9, 1.05));
  EXPECT_TRUE(near(1.05, 1.3));
  EXPECT_TRUE(near(0.9, 0.95));  // within the reach of three voxels
  EXPECT_FALSE(near(0.3, 0.4));
  EXPECT_FALSE(near(1.6, 1.7));
}

/// With one image alone, or images without an object, there is nothing to match.
TEST_F(MatchDepthsOfBalls, NothingToMatchIsNowhereNear) {
  images[1].field = nullptr;
  EXPECT_FALSE(MatchDepths(images, nodes).near({5, 0, 0}));
  images.pop_back();
  EXPECT_FALSE(MatchDepths(images, nodes).near({5, 0, 0}));
}

}  // namespace
}  // namespace slicemorph
