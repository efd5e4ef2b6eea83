#include "engine/blend/local_weights.h"
#include "tests/support/fields.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

Fields threeBalls() {
  Fields fields;
  for (double x : {0.0, 3.0, -2.0})
    fields.push_back(shapes::fieldOf(shapes::sphere({x, 0, 0}, 1), shapes::cube({x, 0, 0}, 1.2), 0.06));
  return fields;
}

std::vector<Chart> straightCharts() {
  return {shapes::straightChart({0, 0, 0}), shapes::straightChart({3, 0, 0}),
          shapes::straightChart({-2, 0, 0})};
}

Region sphere(size_t object, const Vec3d& center, double radius, const Weights& weights) {
  Region r;
  r.name = "ball", r.object = object, r.center = center, r.radius = radius, r.border = 0.2,
  r.weights = weights;
  return r;
}

Region box(size_t object, const openvdb::BBoxd& box, const Weights& weights) {
  Region r;
  r.name = "box", r.kind = Region::Kind::kBox, r.object = object, r.box = box, r.border = 0.2,
  r.weights = weights;
  return r;
}

Region stretch(size_t object, double from, double to, const Weights& weights) {
  Region r;
  r.name = "stretch", r.kind = Region::Kind::kSpine, r.object = object, r.from = from, r.to = to,
  r.border = 0.2, r.weights = weights;
  return r;
}

RegionShares sharesOf(const std::vector<Region>& regions) {
  return {regions, threeBalls(), straightCharts(), straightCharts()};
}

/// 1 half a border inside and 0 half a border outside, by the smooth step of the distance between.
double shareAt(double distance, double border) {
  const double x = std::min(std::max(0.5 - distance / border, 0.0), 1.0);
  return 3 * x * x - 2 * x * x * x;
}

TEST(LocalWeights, SharesFollowTheDistanceToTheRim) {
  const Fields fields = threeBalls();
  const openvdb::BBoxd corner(Vec3d(3, 0, 0), Vec3d(4, 1, 1));
  const RegionShares shares = sharesOf(
      {sphere(0, {0.5, 0, 0}, 0.4, {0, 1, 0}), box(1, corner, {1, 0, 0}), stretch(2, 0.25, 1, {0, 0, 1})});
  std::mt19937 random(1);
  std::uniform_real_distribution<> uniform(-1.2, 1.2);
  for (int i = 0; i < 300; ++i) {
    const Vec3d p(uniform(random), uniform(random), uniform(random));
    const auto at = [&](size_t r, const Vec3d& world) {
      return double(shares.at(r, fields[shares.region(r).object]->relative(world)));
    };
    EXPECT_NEAR(at(0, p), shareAt((p - Vec3d(0.5, 0, 0)).length() - 0.4, 0.2), 1e-5) << p;
    // Distance to the box: outside to its nearest point, inside to its nearest face.
    const Vec3d q = p + Vec3d(3, 0, 0);
    Vec3d out(0.0);
    double in = -1e30;
    for (int a = 0; a < 3; ++a) {
      out[a] = std::max({corner.min()[a] - q[a], q[a] - corner.max()[a], 0.0});
      in = std::max(in, std::max(corner.min()[a] - q[a], q[a] - corner.max()[a]));
    }
    EXPECT_NEAR(at(1, q), shareAt(out.length() > 0 ? out.length() : in, 0.2), 1e-5) << q;
    // The ball's surface samples reach to within a bin of its ends: a sixth of a voxel here.
    EXPECT_NEAR(at(2, p - Vec3d(2, 0, 0)), shareAt(-1 + 0.25 * 2 - p[0], 0.2), 0.06 / 0.2 * 1.5) << p;
  }
}

/// A region from one end of the spine to the other has no boundary.
TEST(LocalWeights, AWholeSpineIsEverywhere) {
  const RegionShares shares = sharesOf({stretch(0, 0, 1, {0, 1, 0})});
  for (double x : {-5.0, -1.0, 0.0, 1.0, 5.0}) EXPECT_EQ(shares.at(0, openvdb::Vec3s(float(x), 0, 0)), 1.f);
}

/// Regions move along with an object that has moved since they were defined.
TEST(LocalWeights, RegionsMoveWithTheirObject) {
  const std::vector<Chart> drawn = straightCharts();
  std::vector<Chart> now = drawn;
  now[0].center = {0, 0, 0.5};
  now[0].axes = rotationFromVector({0, 0, M_PI / 2});
  const RegionShares shares({sphere(0, {0.5, 0, 0}, 0.4, {0, 1, 0})}, threeBalls(), now, drawn);
  EXPECT_NEAR(shares.distance(0, {0, 0.5, 0.5}), -0.4, 1e-9);
  EXPECT_NEAR(shares.distance(0, {0.5, 0, 0}), std::sqrt(0.75) - 0.4, 1e-9);
}

TEST(LocalWeights, ARegionHoldsWhatItsObjectHas) {
  const Fields fields = threeBalls();
  const RegionShares shares =
      sharesOf({sphere(0, {1.3, 0, 0}, 0.4, {0, 1, 0}), sphere(0, {1.6, 0, 0}, 0.4, {0, 1, 0}),
                sphere(0, {0, 0, 0}, 0.1, {0, 1, 0}),
                box(0, openvdb::BBoxd(Vec3d(0.5, -0.1, -0.1), Vec3d(2, 0.1, 0.1)), {0, 1, 0}),
                box(0, openvdb::BBoxd(Vec3d(1.1, -0.1, -0.1), Vec3d(2, 0.1, 0.1)), {0, 1, 0})});
  const bool wanted[5] = {true, false, true, true, false};
  for (size_t r = 0; r < 5; ++r) EXPECT_EQ(shares.holdsAnything(r, *fields[0]), wanted[r]) << r;
}

/// Weights sum to 1 at every position; well inside a region its own weights hold, and where two overlap
/// those of the later one.
TEST(LocalWeights, WeightsSumToOneEverywhere) {
  const Fields fields = threeBalls();
  const Weights whole{0.5, 0.3, 0.2}, first{0, 1, 0}, second{0.1, 0.1, 0.8};
  const RegionShares shares =
      sharesOf({sphere(0, {0.4, 0, 0}, 0.6, first), sphere(0, {-0.4, 0, 0}, 0.6, second)});
  const LocalWeights local(whole, &shares);
  std::mt19937 random(2);
  std::uniform_real_distribution<float> uniform(-1.2f, 1.2f);
  for (int i = 0; i < 300; ++i) {
    const std::vector<openvdb::Vec3s> positions(3, {uniform(random), uniform(random), uniform(random)});
    Weights w(3), blended(3);
    local.find(positions.data(), w.data());
    const float share[2] = {shares.at(0, positions[0]), shares.at(1, positions[0])};
    local.blend(share, blended.data());
    double sum = 0;
    for (size_t k = 0; k < 3; ++k) {
      sum += w[k];
      const double one = whole[k] + double(share[0]) * (first[k] - whole[k]);
      EXPECT_NEAR(w[k], one + double(share[1]) * (second[k] - one), 1e-12);
      EXPECT_EQ(w[k], blended[k]);
      if (share[1] == 1) {
        EXPECT_NEAR(w[k], second[k], 1e-12);
      }
    }
    EXPECT_NEAR(sum, 1, 1e-12);
  }
}

TEST(LocalWeights, KnowWhichObjectsCount) {
  const RegionShares shares =
      sharesOf({sphere(2, {-2, 0, 0}, 0.5, {1, 0, 0}), sphere(2, {-2, 0, 0}, 0.2, {1, 0, 0})});
  EXPECT_EQ(LocalWeights({1, 0, 0}, &shares).used(), (std::vector<size_t>{0, 2}));
  EXPECT_EQ(LocalWeights({1, 0, 0}, &shares).regionObjects(), (std::vector<size_t>{2}));
  EXPECT_EQ(LocalWeights({0.5, 0.5, 0}, nullptr).used(), (std::vector<size_t>{0, 1}));
  EXPECT_TRUE(LocalWeights({0.5, 0.5, 0}, nullptr).regionObjects().empty());
  EXPECT_FALSE(LocalWeights({0.5, 0.5, 0}, nullptr).vary());
  const RegionShares none;
  EXPECT_FALSE(LocalWeights({1}, &none).vary());
}

}  // namespace
}  // namespace slicemorph
