#include "engine/spine/chart.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

Vec3d rotationVector(const Mat3d& m) {
  // By way of the quaternion, from its largest component: accurate up to turns of 180 degrees.
  const double t[4] = {1 + m(0, 0) + m(1, 1) + m(2, 2), 1 + m(0, 0) - m(1, 1) - m(2, 2),
                       1 - m(0, 0) + m(1, 1) - m(2, 2), 1 - m(0, 0) - m(1, 1) + m(2, 2)};
  int k = 0;
  for (int i = 1; i < 4; ++i)
    if (t[i] > t[k]) k = i;
  const double s = 0.5 / std::sqrt(t[k]);
  const Vec3d antisymmetric(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
  double w;
  Vec3d v;
  if (k == 0) {
    w = 0.25 / s;
    v = antisymmetric * s;
  } else {
    const int i = k - 1;
    w = antisymmetric[i] * s;
    for (int j = 0; j < 3; ++j) v[j] = i == j ? 0.25 / s : (m(i, j) + m(j, i)) * s;
  }
  if (w < 0) w = -w, v = -v;
  const double length = v.length();
  if (length < 1e-12) return 2.0 * v;
  return v * (2.0 * std::atan2(length, w) / length);
}

Mat3d rotationFromVector(const Vec3d& v) {
  const double angle = v.length();
  if (angle < 1e-14) return Mat3d::identity();
  const Vec3d k = v / angle;
  const double c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  return Mat3d(c + k[0] * k[0] * d, k[0] * k[1] * d - k[2] * s, k[0] * k[2] * d + k[1] * s,
               k[1] * k[0] * d + k[2] * s, c + k[1] * k[1] * d, k[1] * k[2] * d - k[0] * s,
               k[2] * k[0] * d - k[1] * s, k[2] * k[1] * d + k[0] * s, c + k[2] * k[2] * d);
}

namespace {

/// A step along a spine of constant turn rate; the exponential series up to the fourth order.
struct Step {
  Vec3d turn;  ///< rate times length, radians
  Vec3d turned(const Vec3d& v) const {
    const Vec3d a = turn.cross(v), b = turn.cross(a), c = turn.cross(b), d = turn.cross(c);
    return v + a + b / 2.0 + c / 6.0 + d / 24.0;
  }
  /// End of a unit step along the first axis: the mean of its directions.
  Vec3d end() const {
    const Vec3d v(1, 0, 0), a = turn.cross(v), b = turn.cross(a), c = turn.cross(b), d = turn.cross(c);
    return v + a / 2.0 + b / 6.0 + c / 24.0 + d / 120.0;
  }
  Mat3d matrix() const {
    const Vec3d x = turned({1, 0, 0}), y = turned({0, 1, 0}), z = turned({0, 0, 1});
    return Mat3d(x[0], y[0], z[0], x[1], y[1], z[1], x[2], y[2], z[2]);
  }
};

}  // namespace

struct Bend::Table {
  double half = 1, spacing = 1;
  std::vector<Vec3d> rate;
  std::vector<Bend::Point> station;  ///< `rate`: mean up to the next station
  Vec3d middle{0, 0, 0};
};

Bend::Bend(double half, std::vector<Vec3d> rates) {
  auto table = std::make_shared<Table>();
  table->half = half;
  table->spacing = 2 * half / (kStations - 1);
  table->rate = std::move(rates);
  table->station.resize(kStations);
  constexpr int kMiddle = (kStations - 1) / 2;
  const double h = table->spacing;
  const auto mean = [&](int i) { return 0.5 * (table->rate[i] + table->rate[i + 1]); };
  table->station[kMiddle] = {Vec3d(0.0), Mat3d::identity(), Vec3d(0.0)};
  for (int i = kMiddle; i + 1 < kStations; ++i) {
    Point& p = table->station[i];
    p.rate = mean(i);
    table->station[i + 1] = {p.point + p.frame * (h * Step{h * p.rate}.end()),
                             p.frame * rotationFromVector(h * p.rate), Vec3d(0.0)};
  }
  for (int i = kMiddle; i > 0; --i) {
    const Point& p = table->station[i];
    const Vec3d rate = mean(i - 1);
    table->station[i - 1] = {p.point - p.frame * (h * Step{-h * rate}.end()),
                             p.frame * rotationFromVector(-h * rate), rate};
  }
  for (int i = 0; i < kStations; ++i)
    table->middle += table->station[i].point * ((i == 0 || i == kStations - 1 ? 0.5 : 1) / (kStations - 1));
  table_ = std::move(table);
}

double Bend::half() const { return table_ ? table_->half : 1; }
std::vector<Vec3d> Bend::rates() const {
  return table_ ? table_->rate : std::vector<Vec3d>(kStations, Vec3d(0.0));
}
Vec3d Bend::middle() const { return table_ ? table_->middle : Vec3d(0.0); }

Bend::Point Bend::at(double z0) const {
  if (!table_) return {Vec3d(z0, 0, 0), Mat3d::identity(), Vec3d(0.0)};
  const double x = (z0 + table_->half) / table_->spacing;
  if (!(x > 0) || x >= kStations - 1) {
    const Point& end = x > 0 ? table_->station.back() : table_->station.front();
    const double beyond = x > 0 ? z0 - table_->half : z0 + table_->half;
    return {end.point + end.frame * Vec3d(beyond, 0, 0), end.frame, Vec3d(0.0)};
  }
  const Point& from = table_->station[size_t(x)];
  const double length = (x - std::floor(x)) * table_->spacing;
  const Step step{length * from.rate};
  return {from.point + from.frame * (length * step.end()), from.frame * step.matrix(), from.rate};
}

double Bend::nearest(const Vec3d& point) const {
  int best = 0;
  double least = std::numeric_limits<double>::max();
  for (int i = 0; i < kStations; ++i) {
    const double d = (table_->station[i].point - point).lengthSqr();
    if (d < least) least = d, best = i;
  }
  return stationZ0(best);
}

Vec3d Chart::toWorld(const Vec3d& z) const {
  if (bend.straight()) return center + axes * (scale * z);
  const Bend::Point p = bend.at(z[0]);
  return center + axes * (scale[0] * p.point + p.frame * Vec3d(0, scale[1] * z[1], scale[2] * z[2]));
}

Vec3d Chart::toChart(const Vec3d& world) const {
  const Vec3d p = axes.transpose() * (world - center);
  if (bend.straight()) return p / scale;
  const Vec3d q = p / scale[0];
  double z0 = bend.nearest(q);
  const double longest = 4 * bend.half() / (Bend::kStations - 1);
  Vec3d local;
  for (int i = 0; i < 12; ++i) {
    const Bend::Point on = bend.at(z0);
    local = on.frame.transpose() * (q - on.point);
    if (std::abs(local[0]) < 1e-10) break;
    const double spread = 1 + on.rate[1] * local[2] - on.rate[2] * local[1];
    const double step = local[0] / std::max(spread, 0.3);
    z0 += std::min(std::max(step, -longest), longest);
  }
  return {z0, scale[0] * local[1] / scale[1], scale[0] * local[2] / scale[2]};
}

double Chart::spread(const Vec3d& z) const {
  if (bend.straight()) return 1;
  const Vec3d rate = bend.at(z[0]).rate;
  return 1 + (rate[1] * scale[2] * z[2] - rate[2] * scale[1] * z[1]) / scale[0];
}

Vec3d Chart::normalToChart(const Vec3d& z, const Vec3d& n) const {
  if (bend.straight()) return (scale * (axes.transpose() * n)).unit();
  const Bend::Point p = bend.at(z[0]);
  const Vec3d local = p.frame.transpose() * (axes.transpose() * n);
  const Vec3d along = Vec3d(scale[0], 0, 0) + p.rate.cross(Vec3d(0, scale[1] * z[1], scale[2] * z[2]));
  return Vec3d(local.dot(along), scale[1] * local[1], scale[2] * local[2]).unit();
}

Chart blendCharts(const std::vector<Chart>& charts, const Weights& weights) {
  size_t heaviest = 0;
  for (size_t k = 1; k < charts.size(); ++k)
    if (weights[k] > weights[heaviest]) heaviest = k;
  Chart result;
  result.scale = Vec3d(0.0);
  result.axes = charts[heaviest].axes;
  Vec3d middle(0.0);
  double half = 0;
  std::vector<Vec3d> rates(Bend::kStations, Vec3d(0.0));
  for (size_t k = 0; k < charts.size(); ++k) {
    const Chart& c = charts[k];
    result.scale += weights[k] * c.scale;
    middle += weights[k] * (c.center + c.axes * (c.scale[0] * c.bend.middle()));
    if (c.bend.straight()) continue;
    half = c.bend.half();
    const std::vector<Vec3d> own = c.bend.rates();
    for (size_t i = 0; i < rates.size(); ++i) rates[i] += weights[k] * own[i];
  }
  for (int i = 0; i < 30; ++i) {
    Vec3d step(0.0);
    for (size_t k = 0; k < charts.size(); ++k)
      if (weights[k] != 0) step += weights[k] * rotationVector(result.axes.transpose() * charts[k].axes);
    result.axes = result.axes * rotationFromVector(step);
    if (step.length() < 1e-14) break;
  }
  // Negative weights could make the scale zero or negative.
  for (int axis = 0; axis < 3; ++axis) {
    double least = 1e300;
    for (const Chart& c : charts) least = std::min(least, c.scale[axis]);
    result.scale[axis] = std::max(result.scale[axis], 0.5 * least);
  }
  if (half > 0) result.bend = Bend(half, std::move(rates));
  result.center = middle - result.axes * (result.scale[0] * result.bend.middle());
  return result;
}

Chart reversed(const Chart& chart) {
  const Mat3d flip(-1, 0, 0, 0, 1, 0, 0, 0, -1);
  Chart result = chart;
  result.axes = chart.axes * flip;
  if (chart.bend.straight()) return result;
  std::vector<Vec3d> rates = chart.bend.rates();
  std::reverse(rates.begin(), rates.end());
  for (Vec3d& r : rates) r = Vec3d(r[0], -r[1], r[2]);
  result.bend = Bend(chart.bend.half(), std::move(rates));
  return result;
}

Chart rolled(const Chart& chart, double angle) {
  const Mat3d roll = rotationFromVector({angle, 0, 0});
  Chart result = chart;
  result.axes = chart.axes * roll;
  if (chart.bend.straight()) return result;
  std::vector<Vec3d> rates = chart.bend.rates();
  for (Vec3d& r : rates) r = roll.transpose() * r;
  result.bend = Bend(chart.bend.half(), std::move(rates));
  return result;
}

}  // namespace slicemorph
