// A block of copied grid values compared with the grid itself.
#include "engine/rebuild/local_block.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>

namespace slicemorph {
namespace {

/// Random values, half of them active, and a tile.
template <typename GridType>
typename GridType::Ptr randomGrid() {
  using Value = typename GridType::ValueType;
  auto grid = GridType::create(Value(0.25f));
  std::mt19937 random(1);
  for (auto c = openvdb::CoordBBox({-9, -5, 3}, {9, 11, 21}).begin(); c; ++c) {
    Value v(1.f);
    v *= std::uniform_real_distribution<float>(-1, 1)(random);
    if constexpr (openvdb::VecTraits<Value>::IsVec) v[1] *= 2, v[2] += 1;
    if (random() % 2)
      grid->tree().setValue(*c, v);
    else
      grid->tree().setValueOff(*c, v);
  }
  grid->tree().addTile(1, {8, 0, 8}, Value(2.f), true);
  return grid;
}

std::vector<Vec3d> pointsIn(const openvdb::BBoxd& box) {
  std::mt19937 random(2);
  std::vector<Vec3d> points{box.min(), box.max()};
  for (int n = 0; n < 200; ++n) {
    Vec3d p;
    for (int a = 0; a < 3; ++a) p[a] = std::uniform_real_distribution<>(box.min()[a], box.max()[a])(random);
    points.push_back(p);
  }
  return points;
}

const openvdb::BBoxd kBox(Vec3d(-7.3, -2.1, 6.5), Vec3d(10.2, 7.8, 15.9));

/// The hat function of a voxel, evaluated at a point.
double hat(const Vec3d& p, const openvdb::Coord& c) {
  double w = 1;
  for (int a = 0; a < 3; ++a) w *= std::max(0.0, 1 - std::abs(p[a] - c[a]));
  return w;
}

TEST(LocalBlock, LinearValuesAreTheHatFunctions) {
  const FloatGrid::Ptr grid = randomGrid<FloatGrid>();
  LocalBlock<float> block;
  block.fill<FloatGrid>(grid->getConstAccessor(), kBox);
  for (const Vec3d& p : pointsIn(kBox)) {
    double sum = 0;
    bool active = false;
    const openvdb::Coord low = openvdb::Coord::floor(p);
    for (auto c = openvdb::CoordBBox(low, low.offsetBy(1)).begin(); c; ++c)
      sum += hat(p, *c) * double(grid->tree().getValue(*c)), active |= grid->tree().isValueOn(*c);
    EXPECT_NEAR(block.linear(p, 0), sum, 1e-5) << p;
    EXPECT_EQ(block.active(p), active) << p;
  }
}

TEST(LocalBlock, AmongActiveVoxelsOnlyTheyCount) {
  const auto grid = randomGrid<openvdb::Vec3SGrid>();
  LocalBlock<float> block;
  block.fill<openvdb::Vec3SGrid>(grid->getConstAccessor(), kBox);
  for (const Vec3d& p : pointsIn(kBox)) {
    double share = 0;
    Vec3d sum(0.0);
    const openvdb::Coord low = openvdb::Coord::floor(p);
    for (auto c = openvdb::CoordBBox(low, low.offsetBy(1)).begin(); c; ++c)
      if (grid->tree().isValueOn(*c))
        share += hat(p, *c), sum += hat(p, *c) * Vec3d(grid->tree().getValue(*c));
    float value[3];
    EXPECT_NEAR(block.linearAmongActive(p, value), share, 1e-5) << p;
    for (int a = 0; a < 3; ++a) {
      EXPECT_NEAR(
          block.linear(p, a),
          [&] {
            double all = 0;
            for (auto c = openvdb::CoordBBox(low, low.offsetBy(1)).begin(); c; ++c)
              all += hat(p, *c) * double(grid->tree().getValue(*c)[a]);
            return all;
          }(),
          1e-5);
      if (share > 0.01) {
        EXPECT_NEAR(value[a], sum[a] / share, 1e-3) << p;
      }
    }
  }
}

/// Parabolas along every axis are reproduced where they are monotonic; and a spline never leaves the range of
/// the values around it.
TEST(LocalBlock, SplinesMeetParabolasAndKeepTheirRange) {
  openvdb::DoubleGrid::Ptr grid = openvdb::DoubleGrid::create(0);
  const auto f = [](const Vec3d& p) { return (p[0] + 20) * (p[0] + 20) + (p[1] + 30) * (p[2] + 25); };
  for (auto c = openvdb::CoordBBox({-9, -5, 3}, {13, 11, 21}).begin(); c; ++c)
    grid->tree().setValue(*c, f((*c).asVec3d()));
  LocalBlock<double> block;
  block.fill<openvdb::DoubleGrid>(grid->getConstAccessor(), kBox);
  for (const Vec3d& p : pointsIn(kBox)) EXPECT_NEAR(block.cubic(p, 0), f(p), 1e-9 * f(p)) << p;
  const FloatGrid::Ptr noise = randomGrid<FloatGrid>();
  LocalBlock<float> rough;
  rough.fill<FloatGrid>(noise->getConstAccessor(), kBox);
  for (const Vec3d& p : pointsIn(kBox)) {
    float low = 1e30f, high = -1e30f;
    const openvdb::Coord first = openvdb::Coord::floor(p).offsetBy(-1);
    for (auto c = openvdb::CoordBBox(first, first.offsetBy(3)).begin(); c; ++c)
      low = std::min(low, noise->tree().getValue(*c)), high = std::max(high, noise->tree().getValue(*c));
    EXPECT_GE(rough.cubic(p, 0), low) << p;
    EXPECT_LE(rough.cubic(p, 0), high) << p;
  }
}

TEST(LocalBlock, KnowsWhatIsEmptyOrUniform) {
  FloatGrid::Ptr grid = FloatGrid::create(0.f);
  grid->tree().addTile(1, {8, 8, 8}, 2.f, true);
  LocalBlock<float> block;
  const auto filled = [&](const openvdb::BBoxd& box) {
    block.fill<FloatGrid>(grid->getConstAccessor(), box);
    return std::make_pair(block.anyActive(), block.uniform());
  };
  EXPECT_EQ(filled({Vec3d(-20), Vec3d(-15)}), std::make_pair(false, false));
  EXPECT_EQ(filled({Vec3d(9.5), Vec3d(12.5)}), std::make_pair(true, true));
  EXPECT_EQ(filled({Vec3d(5), Vec3d(12.5)}), std::make_pair(true, false));
  grid->tree().touchLeaf({8, 8, 8});
  EXPECT_EQ(filled({Vec3d(9.5), Vec3d(12.5)}), std::make_pair(true, false));
}

}  // namespace
}  // namespace slicemorph
