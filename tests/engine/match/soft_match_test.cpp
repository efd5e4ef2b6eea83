#include "engine/match/soft_match.h"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace slicemorph {
namespace {

/// From soft_match.cpp: the exponent of the unbalanced update, and the blur lengths that a difference of one
/// between unit normals (a turn by 60 degrees) costs.
constexpr double kUnbalanced = 0.92, kNormals = 1.1;

OrientedPoints cloud(int count, unsigned seed, const Vec3d& middle = Vec3d(0.0)) {
  std::mt19937 random(seed);
  std::normal_distribution<> normal;
  OrientedPoints points;
  double total = 0;
  for (int i = 0; i < count; ++i) {
    points.position.push_back(middle + 0.5 * Vec3d(normal(random), normal(random), normal(random)));
    points.normal.push_back(Vec3d(normal(random), normal(random), normal(random)).unit());
    points.mass.push_back(1 + double(random() % 4));
    total += points.mass.back();
  }
  for (double& m : points.mass) m /= total;
  return points;
}

OrientedPoints single(const Vec3d& position, const Vec3d& normal) { return {{position}, {normal}, {1}}; }

double costOf(const OrientedPoints& a, size_t i, const OrientedPoints& b, size_t j, double blur) {
  return 0.5 * (a.position[i] - b.position[j]).lengthSqr() / (blur * blur) +
         0.5 * kNormals * kNormals * (a.normal[i] - b.normal[j]).lengthSqr();
}

/// Unbalanced Sinkhorn on logarithms, one side after the other, until nothing changes; row i of the plan says
/// what point i of `a` sends to every point of `b`.
std::vector<std::vector<double>> planOf(const OrientedPoints& a, const OrientedPoints& b, double blur) {
  const size_t n = a.mass.size(), m = b.mass.size();
  std::vector<double> f(n, 0), g(m, 0);
  for (int round = 0; round < 2000; ++round) {
    for (size_t i = 0; i < n; ++i) {
      double sum = 0;
      for (size_t j = 0; j < m; ++j) sum += std::exp(g[j] - costOf(a, i, b, j, blur));
      f[i] = kUnbalanced * (std::log(a.mass[i]) - std::log(sum));
    }
    for (size_t j = 0; j < m; ++j) {
      double sum = 0;
      for (size_t i = 0; i < n; ++i) sum += std::exp(f[i] - costOf(a, i, b, j, blur));
      g[j] = kUnbalanced * (std::log(b.mass[j]) - std::log(sum));
    }
  }
  std::vector<std::vector<double>> plan(n, std::vector<double>(m));
  for (size_t i = 0; i < n; ++i)
    for (size_t j = 0; j < m; ++j) plan[i][j] = std::exp(f[i] + g[j] - costOf(a, i, b, j, blur));
  return plan;
}

Vec3d meanOf(const std::vector<double>& row, const OrientedPoints& to) {
  Vec3d sum(0.0);
  double total = 0;
  for (size_t j = 0; j < row.size(); ++j) sum += row[j] * to.position[j], total += row[j];
  return sum / total;
}

/// A blur as wide as the clouds, so that the plan is found within the rounds there are: the errors of its
/// second mode shrink by at least a third in each of 25.
TEST(SoftMatch, AgreesWithADenseSinkhorn) {
  const double blur = 1;
  const OrientedPoints a = cloud(14, 1), b = cloud(11, 2, {0.4, 0.2, 0});
  const SoftMatch match = softMatch(a, b, blur);
  const auto plan = planOf(a, b, blur), home = planOf(a, a, blur);
  for (size_t i = 0; i < a.mass.size(); ++i) {
    double sent = 0;
    for (double p : plan[i]) sent += p;
    const Vec3d target = a.position[i] + meanOf(plan[i], b) - meanOf(home[i], a);
    EXPECT_LE((match.aToB.position[i] - target).length(), 1e-3 * blur) << i;
    EXPECT_NEAR(match.aToB.trust[i], sent / a.mass[i], 1e-3) << i;
  }
}

/// One point each: u = v = (1 / k u)^b, and k u v of the mass is sent.
TEST(SoftMatch, TwoPointsInClosedForm) {
  const double blur = 0.4;
  const auto trustOf = [&](const Vec3d& p, const Vec3d& n) {
    const SoftMatch m = softMatch(single({0, 0, 0}, {1, 0, 0}), single(p, n), blur);
    EXPECT_LE((m.aToB.position[0] - p).length(), 1e-5);
    EXPECT_LE(m.bToA.position[0].length(), 1e-5);
    EXPECT_NEAR(m.aToB.trust[0], m.bToA.trust[0], 1e-5);
    return m.aToB.trust[0];
  };
  const double power = (1 - kUnbalanced) / (1 + kUnbalanced);
  for (double d : {0.0, 0.3, 1.0, 1.8})
    EXPECT_NEAR(trustOf({0, d, 0}, {1, 0, 0}), std::exp(-power * 0.5 * d * d / (blur * blur)), 1e-4) << d;
  // A normal that is turned by 60 degrees costs as much as a distance.
  EXPECT_NEAR(trustOf({0, 0, 0}, {0.5, std::sqrt(0.75), 0}), trustOf({0, kNormals * blur, 0}, {1, 0, 0}),
              1e-5);
}

TEST(SoftMatch, ASurfaceGoesOntoItself) {
  const OrientedPoints a = cloud(40, 3);
  const SoftMatch match = softMatch(a, a, 0.3);
  for (size_t i = 0; i < a.mass.size(); ++i) {
    EXPECT_LE((match.aToB.position[i] - a.position[i]).length(), 1e-4);
    EXPECT_LE((match.bToA.position[i] - a.position[i]).length(), 1e-4);
  }
}

TEST(SoftMatch, IsSymmetric) {
  const OrientedPoints a = cloud(30, 4), b = cloud(37, 5, {0.5, 0, 0});
  const SoftMatch ab = softMatch(a, b, 0.3), ba = softMatch(b, a, 0.3);
  for (size_t i = 0; i < a.mass.size(); ++i) {
    EXPECT_LE((ab.aToB.position[i] - ba.bToA.position[i]).length(), 1e-4);
    EXPECT_NEAR(ab.aToB.trust[i], ba.bToA.trust[i], 1e-4);
  }
}

/// What leaves one surface arrives on the other.
TEST(SoftMatch, MassIsKept) {
  const OrientedPoints a = cloud(30, 6), b = cloud(23, 7, {0.3, 0.6, 0});
  const SoftMatch match = softMatch(a, b, 0.25);
  double sent = 0, arrived = 0;
  for (size_t i = 0; i < a.mass.size(); ++i) sent += a.mass[i] * match.aToB.trust[i];
  for (size_t j = 0; j < b.mass.size(); ++j) arrived += b.mass[j] * match.bToA.trust[j];
  EXPECT_NEAR(sent, arrived, 1e-4);
  EXPECT_GT(sent, 0.5);
}

/// Both points have the same nearest point, to which each alone would go; together the second goes to the
/// other one, except for the mass that the first does not transport.
TEST(SoftMatch, NoTwoPointsShareAPartner) {
  const Vec3d n(0, 0, 1);
  const double blur = 0.4;
  const OrientedPoints a{{{0, 0, 0}, {1, 0, 0}}, {n, n}, {0.5, 0.5}};
  const OrientedPoints b{{{0.9, 0, 0}, {1.9, 0, 0}}, {n, n}, {0.5, 0.5}};
  const SoftMatch match = softMatch(a, b, blur);
  const auto plan = planOf(a, b, blur), home = planOf(a, a, blur);
  for (size_t i = 0; i < 2; ++i) {
    const Vec3d target = a.position[i] + meanOf(plan[i], b) - meanOf(home[i], a);
    EXPECT_LE((match.aToB.position[i] - target).length(), 0.01) << i;
  }
  EXPECT_LT(match.aToB.position[0][0], 1.4);
  EXPECT_GT(match.aToB.position[1][0], 1.4);
}

/// Sides of a thin wall face away from each other: they do not mix though they are near.
TEST(SoftMatch, NormalsKeepSidesApart) {
  const Vec3d up(0, 0, 1), down(0, 0, -1);
  const OrientedPoints a{{{0, 0, 0.02}, {0, 0, -0.02}}, {up, down}, {0.5, 0.5}};
  const OrientedPoints b{{{0.1, 0, 0.02}, {-0.1, 0, -0.02}}, {up, down}, {0.5, 0.5}};
  const SoftMatch match = softMatch(a, b, 0.3);
  // Wrong sides differ by 2 in their normals: exp(-1.1^2 2^2 / 2) = 9 % of a partner's share at the most.
  EXPECT_NEAR(match.aToB.position[0][0], 0.1, 0.02);
  EXPECT_NEAR(match.aToB.position[1][0], -0.1, 0.02);
}

}  // namespace
}  // namespace slicemorph
