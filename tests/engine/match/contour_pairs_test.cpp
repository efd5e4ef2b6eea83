// Contours of circles, whose overlaps have closed forms, matched by trying every assignment.
#include "engine/match/contour_pairs.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

namespace slicemorph {
namespace {

constexpr int kPairCorners = 240;

Contour circle(const Vec2d& middle, double radius, bool hole = false, double first = 0) {
  Contour c;
  for (int i = 0; i < kPairCorners; ++i) {
    const double phase = first + (hole ? -1 : 1) * 2 * M_PI * i / kPairCorners;
    c.points.push_back(middle + radius * Vec2d(std::cos(phase), std::sin(phase)));
  }
  c.area = (hole ? -1 : 1) * M_PI * radius * radius, c.centroid = middle;
  return c;
}

/// One slice whose base warp is `scale` times the middle on every object.
BaseWarp warpOf(const std::vector<double>& scales, size_t slices = 1) {
  BaseWarp base;
  for (size_t i = 0; i < slices; ++i) base.z0.push_back(0.1 * double(i));
  base.middle.assign(slices, SliceAffine{});
  for (double s : scales) {
    base.objects.emplace_back(slices, SliceAffine{{0, 0}, s, 0, s});
    base.position.push_back(base.z0);
  }
  for (size_t k = 0; k < base.position.size(); ++k)
    for (double& z : base.position[k]) z += 0.01 * double(k);
  return base;
}

/// Intersection over union of two circles, by the lens between them.
double overlapOf(const Contour& a, const Contour& b) {
  const double r = std::sqrt(std::abs(a.area) / M_PI), s = std::sqrt(std::abs(b.area) / M_PI),
               d = (a.centroid - b.centroid).length();
  double lens = 0;
  if (d <= std::abs(r - s))
    lens = M_PI * std::min(r, s) * std::min(r, s);
  else if (d < r + s)
    lens = r * r * std::acos((d * d + r * r - s * s) / (2 * d * r)) +
           s * s * std::acos((d * d + s * s - r * r) / (2 * d * s)) -
           0.5 * std::sqrt((-d + r + s) * (d + r - s) * (d - r + s) * (d + r + s));
  return lens / (M_PI * (r * r + s * s) - lens);
}

double costOf(const Contour& a, const Contour& b) {
  if (a.hole() != b.hole()) return 1e6;
  return 1.2 * (a.centroid - b.centroid).length() + 0.35 * std::abs(std::log(std::abs(a.area / b.area)));
}

using Matches = std::vector<std::pair<size_t, size_t>>;

/// The cheapest of all ways to give every contour of the smaller set one of the larger, without the pairs
/// that overlap by less than 0.4.
Matches bestMatches(const std::vector<Contour>& a, const std::vector<Contour>& b) {
  if (a.size() > b.size()) {
    Matches m = bestMatches(b, a);
    for (auto& pair : m) std::swap(pair.first, pair.second);
    std::sort(m.begin(), m.end());
    return m;
  }
  std::vector<size_t> order(b.size()), best;
  std::iota(order.begin(), order.end(), size_t(0));
  double least = 1e300;
  do {
    double cost = 0;
    for (size_t i = 0; i < a.size(); ++i) cost += costOf(a[i], b[order[i]]);
    if (cost < least - 1e-12) least = cost, best = order;
  } while (std::next_permutation(order.begin(), order.end()));
  Matches m;
  for (size_t i = 0; i < a.size(); ++i)
    if (costOf(a[i], b[best[i]]) < 1e5 && overlapOf(a[i], b[best[i]]) >= 0.4) m.emplace_back(i, best[i]);
  return m;
}

/// Scan lines across the higher of two circles: their ends are off by up to a line each.
constexpr double kScan = 2.0 / 64;

TEST(ContourPairs, AreTheCheapestOfAllAssignments) {
  std::mt19937 random(4);
  std::uniform_real_distribution<> position(-0.5, 0.5), size(0.3, 0.7);
  size_t pairs = 0, refused = 0;
  for (int repeat = 0; repeat < 60; ++repeat) {
    std::vector<Contour> slice[2];
    for (auto& contours : slice)
      for (size_t i = 0, n = 1 + random() % 4; i < n; ++i)
        contours.push_back(circle({position(random), position(random)}, size(random), random() % 4 == 0));
    // Where an overlap is too near to the bound the scan lines cannot tell.
    bool clear = true;
    for (const Contour& a : slice[0])
      for (const Contour& b : slice[1]) clear &= std::abs(overlapOf(a, b) - 0.4) > kScan;
    if (!clear) continue;
    Matches found;
    for (const ContourPair& p : matchContours({{slice[0]}, {slice[1]}}, warpOf({1, 1}))) {
      EXPECT_EQ(p.slice, 0u);
      EXPECT_EQ(p.objectA, 0u);
      EXPECT_EQ(p.objectB, 1u);
      EXPECT_NEAR(p.overlap, overlapOf(slice[0][p.contourA], slice[1][p.contourB]), kScan);
      EXPECT_EQ(slice[0][p.contourA].hole(), slice[1][p.contourB].hole());
      found.emplace_back(p.contourA, p.contourB);
    }
    std::sort(found.begin(), found.end());
    EXPECT_EQ(found, bestMatches(slice[0], slice[1])) << repeat;
    pairs += found.size(), refused += std::min(slice[0].size(), slice[1].size()) - found.size();
  }
  // The cases had both.
  EXPECT_GT(pairs, 10u);
  EXPECT_GT(refused, 10u);
}

/// A circle and one of half the radius overlap by a quarter, but where the base warp makes them alike by all.
TEST(ContourPairs, AreJudgedInTheMiddleSlice) {
  const std::vector<ContourStack> stacks{{{circle({0, 0}, 1)}}, {{circle({0, 0}, 0.5)}}};
  EXPECT_TRUE(matchContours(stacks, warpOf({1, 1})).empty());
  const auto pairs = matchContours(stacks, warpOf({1, 0.5}));
  ASSERT_EQ(pairs.size(), 1u);
  EXPECT_NEAR(pairs[0].overlap, 1, 1e-3);
}

/// Every object with the next one, and the last with the first.
TEST(ContourPairs, ObjectsStandInARing) {
  const std::vector<ContourStack> stacks(4, {{circle({0, 0}, 1)}, {}, {circle({0, 0}, 2)}});
  std::vector<std::pair<size_t, size_t>> met;
  for (const ContourPair& p : matchContours(stacks, warpOf({1, 1, 1, 1}, 3))) {
    EXPECT_NE(p.slice, 1u);
    if (p.slice == 0) met.emplace_back(p.objectA, p.objectB);
  }
  EXPECT_EQ(met, (std::vector<std::pair<size_t, size_t>>{{0, 1}, {1, 2}, {2, 3}, {0, 3}}));
}

/// The other contour begins elsewhere; the shift of best correlation is a whole number of samples.
TEST(ContourPairs, PointsAreJoinedAtTheBestStart) {
  constexpr int kSamples = 24;
  const int begins = 7;
  // A plate of 8 by 4: its corners and samples lie whole units of its length apart, wherever it begins.
  const auto plate = [](double size, int first) {
    const Vec2d side[4] = {{1, 0}, {0, 1}, {-1, 0}, {0, -1}};
    Contour c;
    Vec2d p(-4, -2);
    for (int i = 0; i < kSamples; ++i, p += side[i <= 8 ? 0 : i <= 12 ? 1 : i <= 20 ? 2 : 3]) {
      c.points.push_back(size * p);
    }
    std::rotate(c.points.begin(), c.points.begin() + first, c.points.end());
    return c;
  };
  const std::vector<ContourStack> stacks{{{plate(1, 0)}}, {{plate(0.5, begins)}}, {{}}};
  const BaseWarp base = warpOf({1, 0.5, 2});
  const auto points = pairCorrespondences({{0, 0, 0, 1, 0, 1.0}}, stacks, base, kSamples);
  ASSERT_EQ(points.size(), size_t(kSamples));
  const std::vector<Vec2d> wanted = resample(plate(1, 0), kSamples);
  for (int i = 0; i < kSamples; ++i) {
    const Correspondence& c = points[size_t(i)];
    const Vec2d p = wanted[size_t(i)];
    EXPECT_LE((c.at[0] - Vec3d(base.position[0][0], p[0], p[1])).length(), 1e-9) << i;
    EXPECT_LE((c.at[1] - Vec3d(base.position[1][0], 0.5 * p[0], 0.5 * p[1])).length(), 1e-9) << i;
    // One that has no part in it follows the base warp.
    EXPECT_LE((c.at[2] - Vec3d(base.position[2][0], 2 * p[0], 2 * p[1])).length(), 1e-9) << i;
    EXPECT_LE((c.middle - (c.at[0] + c.at[1] + c.at[2]) / 3.0).length(), 1e-12) << i;
  }
}

}  // namespace
}  // namespace slicemorph
