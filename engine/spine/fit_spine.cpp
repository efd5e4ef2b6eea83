#include "engine/spine/fit_spine.h"

#include "engine/frame/moments.h"
#include "engine/spine/geodesics.h"

#include <Eigen/Cholesky>
#include <Eigen/Core>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slicemorph {

namespace {

constexpr int kSections = 65;
/// Of the penalty on third differences: waves shorter than a quarter of the axis are not followed.
constexpr double kSmooth = 30, kEnd = 0.25;
/// An object shorter than this many times its width has no clear axis.
constexpr double kSlender = 1.8;
/// Where slices come closer together than this the chart is of no use; how much of the object may lie there.
constexpr double kLeastSpread = 0.4, kMostCrossed = 0.01;
/// How the ends are found: how far from its end a slice is to be trusted wholly, in widths of the slice, and the penalty on
/// third differences there. Once the axis is nearly right its ends may be followed closer; it must not grow by that, for an
/// axis that curls up at an end is longer.
struct Ends {
  double cap, smoothEnds;
};
constexpr Ends kEarly{0.8, 100}, kLate{0.3, 30};
constexpr int kRounds = 9, kLateRounds = 8;
constexpr double kVolumeTolerance = 0.03;

/// Trust in a slice by its distance to the axis' end: near an end it may be cut askew by the end cap. `cap`: in widths of
/// the slice, where trust begins to fade.
double awayFromEnd(double distance, double area, double cap) {
  const double clear = std::min(distance / std::max(cap * std::sqrt(std::max(area, 0.0)), 1e-300), 1.0);
  return clear * clear * clear * clear;
}

/// Evenly spaced points of least third differences near the given ones, each as near as its weight tells.
std::vector<Vec3d> smoothed(const std::vector<Vec3d>& points, const std::vector<double>& weights, double atEnds) {
  const int n = int(points.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n), b(n, 3);
  for (int i = 0; i < n; ++i) {
    a(i, i) = weights[size_t(i)] + 1e-9;
    for (int d = 0; d < 3; ++d) b(i, d) = a(i, i) * points[size_t(i)][d];
  }
  const double third[4] = {-1, 3, -3, 1};
  for (int i = 0; i + 3 < n; ++i) {
    // Towards an end the axis goes on as it came from further in.
    const double end = std::max(1 - std::min(i, n - 4 - i) / (kEnd * n), 0.0);
    const double stiffness = kSmooth * std::pow(atEnds / kSmooth, end);
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) a(i + j, i + k) += stiffness * third[j] * third[k];
  }
  const Eigen::MatrixXd x = a.ldlt().solve(b);
  std::vector<Vec3d> result;
  for (int i = 0; i < n; ++i) result.emplace_back(x(i, 0), x(i, 1), x(i, 2));
  return result;
}

/// `count` points evenly spaced along a polyline.
std::vector<Vec3d> evenly(const std::vector<Vec3d>& line, int count) {
  std::vector<double> at{0};
  for (size_t i = 1; i < line.size(); ++i) at.push_back(at.back() + (line[i] - line[i - 1]).length());
  std::vector<Vec3d> result;
  size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const double s = at.back() * k / (count - 1);
    while (i + 2 < line.size() && at[i + 1] < s) ++i;
    result.push_back(line[i] + (line[i + 1] - line[i]) * ((s - at[i]) / std::max(at[i + 1] - at[i], 1e-300)));
  }
  return result;
}

/// Frames along evenly spaced points that do not spin (double reflection; Wang et al. 2008), as a chart with slices in
/// world units.
Chart chartThrough(const std::vector<Vec3d>& points) {
  const int n = Bend::kStations;
  const std::vector<Vec3d> p = evenly(points, n);
  std::vector<Vec3d> tangent(n), side(n);
  for (int i = 0; i < n; ++i) tangent[i] = (p[std::min(i + 1, n - 1)] - p[std::max(i - 1, 0)]).unit();
  side[0] = std::abs(tangent[0][0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  side[0] = (side[0] - side[0].dot(tangent[0]) * tangent[0]).unit();
  for (int i = 0; i + 1 < n; ++i) {
    const Vec3d v1 = p[i + 1] - p[i];
    const double c1 = v1.lengthSqr();
    const Vec3d s = side[i] - v1 * (2 / c1 * v1.dot(side[i])), t = tangent[i] - v1 * (2 / c1 * v1.dot(tangent[i]));
    const Vec3d v2 = tangent[i + 1] - t;
    const double c2 = v2.lengthSqr();
    side[i + 1] = c2 > 1e-30 ? s - v2 * (2 / c2 * v2.dot(s)) : s;
    side[i + 1] = (side[i + 1] - side[i + 1].dot(tangent[i + 1]) * tangent[i + 1]).unit();
  }
  std::vector<Mat3d> frame;
  for (int i = 0; i < n; ++i) {
    const Vec3d e2 = tangent[i].cross(side[i]);
    frame.emplace_back(tangent[i][0], side[i][0], e2[0], tangent[i][1], side[i][1], e2[1], tangent[i][2], side[i][2], e2[2]);
  }
  const double spacing = 2.0 / (n - 1);
  std::vector<Vec3d> between, rates;
  for (int i = 0; i + 1 < n; ++i) between.push_back(rotationVector(frame[i].transpose() * frame[i + 1]) / spacing);
  for (int i = 0; i < n; ++i) rates.push_back(0.5 * (between[std::max(i - 1, 0)] + between[std::min(i, n - 2)]));
  double length = 0;
  for (int i = 0; i + 1 < n; ++i) length += (p[i + 1] - p[i]).length();
  Chart chart;
  chart.axes = frame[(n - 1) / 2];
  chart.scale = Vec3d(0.5 * length, 1, 1);
  chart.bend = Bend(1, std::move(rates));
  // The integrated spine, laid over the points as a whole.
  Vec3d mean(0.0);
  for (int i = 0; i < n; ++i) mean += p[i] * ((i == 0 || i == n - 1 ? 0.5 : 1) / (n - 1));
  chart.center = mean - chart.axes * (chart.scale[0] * chart.bend.middle());
  return chart;
}

std::vector<Vec3d> geodesicStart(const InsideNodes& nodes) {
  const Geodesics ways(nodes);
  size_t middle = 0;
  Vec3d mean(0.0);
  for (const Vec3d& p : nodes.position) mean += p / double(nodes.position.size());
  for (size_t i = 0; i < nodes.position.size(); ++i)
    if ((nodes.position[i] - mean).lengthSqr() < (nodes.position[middle] - mean).lengthSqr()) middle = i;
  const Geodesics::Ways waysFromA = ways.from(ways.from(middle).farthest());
  const std::vector<double>& fromA = waysFromA.length;
  const std::vector<double> fromB = ways.from(waysFromA.farthest()).length;
  size_t reached = 0;
  double most = 0;
  for (double d : fromA)
    if (std::isfinite(d)) ++reached, most = std::max(most, d);
  if (double(reached) < 0.97 * double(nodes.position.size())) return {};
  std::vector<Vec3d> sum(kSections, Vec3d(0.0));
  std::vector<double> weight(kSections, 0);
  for (size_t i = 0; i < nodes.position.size(); ++i) {
    if (!std::isfinite(fromA[i])) continue;
    const double u = (0.5 + 0.5 * (fromA[i] - fromB[i]) / most) * (kSections - 1);
    const int bin = std::min(std::max(int(std::lround(u)), 0), kSections - 1);
    sum[bin] += nodes.share[i] * nodes.position[i], weight[bin] += nodes.share[i];
  }
  // Ways that start at a tip spread from it like rings: near the tips they tell nothing of the axis.
  constexpr double kTip = 1.2;
  const double length = most / (kSections - 1);
  for (int i = 0; i < kSections; ++i) {
    if (weight[i] > 0) sum[i] /= weight[i];
    else sum[i] = mean;
    const double area = weight[i] * nodes.spacing * nodes.spacing * nodes.spacing / length;
    weight[i] = awayFromEnd(length * std::min(i, kSections - 1 - i), area, kTip);
  }
  return smoothed(sum, weight, kEarly.smoothEnds);
}

/// Chart coordinates of all nodes.
std::vector<Vec3d> inChart(const Chart& chart, const InsideNodes& nodes) {
  std::vector<Vec3d> z(nodes.position.size());
  tbb::parallel_for(size_t(0), z.size(), [&](size_t i) { z[i] = chart.toChart(nodes.position[i]); });
  return z;
}

/// The axis through the centroids of the chart's own slices, from tip to tip.
std::vector<Vec3d> throughCentroids(const Chart& chart, const InsideNodes& nodes, const Ends& ends) {
  const std::vector<Vec3d> z = inChart(chart, nodes);
  double low = 1e300, high = -1e300;
  for (size_t i = 0; i < z.size(); ++i) {
    const double reach = std::max(nodes.depth[i], 0.0) / chart.scale[0];
    low = std::min(low, z[i][0] - reach), high = std::max(high, z[i][0] + reach);
  }
  const double spacing = (high - low) / (kSections - 1);
  std::vector<double> area(kSections, 0), x(kSections, 0), y(kSections, 0);
  for (size_t i = 0; i < z.size(); ++i) {
    const double u = (z[i][0] - low) / spacing;
    const int below = std::min(std::max(int(u), 0), kSections - 2);
    const double w = nodes.share[i] / std::max(chart.spread(z[i]), 0.3), f = u - below;
    for (int side = 0; side < 2; ++side) {
      const double v = w * (side ? f : 1 - f);
      area[below + side] += v, x[below + side] += v * z[i][1], y[below + side] += v * z[i][2];
    }
  }
  area.front() *= 2, area.back() *= 2, x.front() *= 2, x.back() *= 2, y.front() *= 2, y.back() *= 2;
  // Of the slices, from volume per section.
  const double areaUnit = nodes.spacing * nodes.spacing * nodes.spacing / (spacing * chart.scale[0]);
  std::vector<Vec3d> points;
  std::vector<double> weights;
  for (int i = 0; i < kSections; ++i) {
    const double z0 = low + i * spacing;
    points.push_back(chart.toWorld({z0, area[i] > 0 ? x[i] / area[i] : 0, area[i] > 0 ? y[i] / area[i] : 0}));
    // Slices where the object ends or narrows suddenly, and those at an end cap, which are cut askew as long as the axis
    // is not right, are trusted least.
    double least = 1e300, most = 0;
    for (int j = std::max(i - 4, 0); j <= std::min(i + 4, kSections - 1); ++j)
      least = std::min(least, area[j]), most = std::max(most, area[j]);
    const double full = most > 0 ? least / most : 0;
    const double toEnd = std::min(z0 - low, high - z0) * chart.scale[0];
    weights.push_back(full * full * awayFromEnd(toEnd, area[i] * areaUnit, ends.cap));
  }
  return smoothed(points, weights, ends.smoothEnds);
}

/// Volume that the chart's slices count: once everywhere, if the chart is sound.
double countedVolume(const DistanceField& field, const Chart& chart, const std::vector<Vec3d>& inside) {
  openvdb::BBoxd box;
  for (const Vec3d& z : inside) box.expand(z);
  constexpr int kAlong = 96, kAcross = 48;
  const Vec3d margin = 0.1 * box.extents(), low = box.min() - margin, extent = box.extents() + 2.0 * margin;
  const Vec3d cell(extent[0] / kAlong, extent[1] / kAcross, extent[2] / kAcross);
  const double soft = std::max({chart.scale[0] * cell[0], chart.scale[1] * cell[1], chart.scale[2] * cell[2]});
  std::vector<double> sums(kAlong, 0);
  tbb::parallel_for(0, kAlong, [&](int i) {
    const DistanceField::Sampler sampler(field);
    for (int j = 0; j < kAcross; ++j)
      for (int k = 0; k < kAcross; ++k) {
        const Vec3d z = low + cell * Vec3d(i + 0.5, j + 0.5, k + 0.5);
        const double spread = chart.spread(z);
        if (spread <= 0) continue;
        const double d = sampler.coarse(field.relative(chart.toWorld(z)));
        sums[size_t(i)] += spread * std::min(std::max(0.5 - d / soft, 0.0), 1.0);
      }
  });
  const double unit = cell[0] * cell[1] * cell[2] * chart.scale[0] * chart.scale[1] * chart.scale[2];
  return std::accumulate(sums.begin(), sums.end(), 0.0) * unit;
}

/// How far the spine lies from the line between its ends.
double distanceFromChord(const Chart& chart) {
  const Vec3d a = chart.toWorld({-1, 0, 0}), chord = chart.toWorld({1, 0, 0}) - a;
  double most = 0;
  for (int i = 0; i <= 64; ++i) {
    const Vec3d d = chart.toWorld({i / 32.0 - 1, 0, 0}) - a;
    const double along = std::min(std::max(d.dot(chord) / std::max(chord.lengthSqr(), 1e-300), 0.0), 1.0);
    most = std::max(most, (d - along * chord).length());
  }
  return most;
}

/// Points along the longest principal axis of the inside.
std::vector<Vec3d> straightStart(const InsideNodes& nodes) {
  Vec3d mean(0.0);
  for (const Vec3d& p : nodes.position) mean += p / double(nodes.position.size());
  Mat3d covariance = Mat3d::zero();
  for (const Vec3d& p : nodes.position)
    for (int i = 0; i < 3; ++i)
      for (int j = 0; j < 3; ++j) covariance(i, j) += (p - mean)[i] * (p - mean)[j];
  const Mat3d axes = principalAxes(covariance).axes;
  const Vec3d axis(axes(0, 0), axes(1, 0), axes(2, 0));
  double low = 0, high = 0;
  for (const Vec3d& p : nodes.position) low = std::min(low, (p - mean).dot(axis)), high = std::max(high, (p - mean).dot(axis));
  return {mean + low * axis, mean + high * axis};
}

/// The axis from a first guess; nothing where it is no sound chart of the object.
std::optional<Chart> settled(const DistanceField& field, const InsideNodes& nodes, const std::vector<Vec3d>& start) {
  if (start.empty()) return std::nullopt;
  Chart chart = chartThrough(start);
  for (int round = 0; round < kRounds; ++round) chart = chartThrough(throughCentroids(chart, nodes, kEarly));
  Chart closer = chart;
  for (int round = 0; round < kLateRounds; ++round) {
    closer = chartThrough(throughCentroids(closer, nodes, kLate));
    if (closer.scale[0] < chart.scale[0]) chart = closer;
  }
  const double volume = nodes.volume(), radius = std::sqrt(volume / (2 * chart.scale[0]));
  chart.scale[1] = chart.scale[2] = radius;
  if (!(2 * chart.scale[0] > kSlender * radius)) return std::nullopt;
  const std::vector<Vec3d> z = inChart(chart, nodes);
  double crossed = 0, all = 0;
  for (size_t i = 0; i < z.size(); ++i) {
    all += nodes.share[i];
    if (chart.spread(z[i]) < kLeastSpread || (chart.toWorld(z[i]) - nodes.position[i]).length() > 0.01 * radius)
      crossed += nodes.share[i];
  }
  if (crossed > kMostCrossed * all) return std::nullopt;
  if (std::abs(countedVolume(field, chart, z) / volume - 1) > kVolumeTolerance) return std::nullopt;
  return chart;
}

}  // namespace

std::optional<FittedSpine> fitSpine(const DistanceField& field) {
  const InsideNodes nodes = InsideNodes(field);
  std::optional<Chart> best;
  // Of two sound axes the shorter: the other one curls up at an end.
  for (const std::vector<Vec3d>& start : {straightStart(nodes), geodesicStart(nodes)}) {
    const std::optional<Chart> chart = settled(field, nodes, start);
    if (chart && (!best || chart->scale[0] < best->scale[0])) best = chart;
  }
  if (!best) return std::nullopt;
  return FittedSpine{*best, distanceFromChord(*best) / best->scale[1]};
}

}  // namespace slicemorph
