#include "engine/match/limb_pairs.h"

#include "engine/match/assignment.h"

#include <cmath>

namespace slicemorph {

namespace {

/// Costs of a difference of one size in where a limb leaves the body and in where its tip is, and of lengths that differ
/// by the factor e; and what being left without a partner costs.
constexpr double kRootPrice = 2, kTipPrice = 0.5, kLengthPrice = 0.4, kAlonePrice = 1.3;
/// The first points of a limb's line, which tell where it leaves the body.
constexpr int kRootPoints = 4;

double costOf(const PlacedLimb& a, const PlacedLimb& b, double size) {
  Vec3d root(0.0);
  for (int i = 0; i < kRootPoints; ++i) root += (a.middle[size_t(i)] - b.middle[size_t(i)]) / double(kRootPoints);
  const double tip = (a.middle.back() - b.middle.back()).length();
  return (kRootPrice * root.length() + kTipPrice * tip) / size + kLengthPrice * std::abs(std::log(a.length / b.length));
}

Vec3d directionAt(const std::vector<Vec3d>& line, size_t i) {
  const Vec3d d = line[std::min(i + 1, line.size() - 1)] - line[i > 0 ? i - 1 : 0];
  return d.length() > 0 ? d.unit() : Vec3d(1, 0, 0);
}

/// `v` turned the way that takes one direction to another.
Vec3d carried(const Vec3d& v, const Vec3d& from, const Vec3d& to) {
  const Vec3d axis = from.cross(to);
  const double s = axis.length();
  return s < 1e-9 ? v : rotationFromVector(axis / s * std::atan2(s, from.dot(to))) * v;
}

}  // namespace

std::vector<int> matchLimbs(const std::vector<PlacedLimb>& a, const std::vector<PlacedLimb>& b, double size) {
  if (a.empty() || b.empty()) return std::vector<int>(a.size(), -1);
  std::vector<std::vector<double>> cost(a.size(), std::vector<double>(b.size() + a.size(), kAlonePrice));
  for (size_t i = 0; i < a.size(); ++i)
    for (size_t j = 0; j < b.size(); ++j) cost[i][j] = costOf(a[i], b[j], size);
  std::vector<int> partner = assign(cost);
  for (int& p : partner)
    if (p >= int(b.size())) p = -1;
  return partner;
}

std::vector<std::pair<Vec3d, Vec3d>> limbPoints(const PlacedLimb& a, const PlacedLimb& b) {
  std::vector<std::pair<Vec3d, Vec3d>> points;
  // One frame for both where they leave the body, then each its own way.
  Vec3d ta = directionAt(a.chart, 0), tb = directionAt(b.chart, 0);
  Vec3d side = std::abs(ta[0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  Vec3d ea = (side - side.dot(ta) * ta).unit(), eb = carried(ea, ta, tb);
  for (size_t i = 0; i < a.chart.size(); ++i) {
    const Vec3d na = directionAt(a.chart, i), nb = directionAt(b.chart, i);
    ea = carried(ea, ta, na), eb = carried(eb, tb, nb);
    ta = na, tb = nb;
    points.emplace_back(a.chart[i], b.chart[i]);
    const Vec3d fa = ta.cross(ea), fb = tb.cross(eb);
    for (int q = 0; q < 4; ++q) {
      const double x = q == 0 ? 1 : q == 1 ? -1 : 0, y = q == 2 ? 1 : q == 3 ? -1 : 0;
      points.emplace_back(a.chart[i] + a.radius[i] * (x * ea + y * fa), b.chart[i] + b.radius[i] * (x * eb + y * fb));
    }
  }
  return points;
}

}  // namespace slicemorph
