#include "engine/spine/fit_spine.h"

#include "engine/spine/geodesics.h"
#include "engine/volume/moments.h"

#include <tbb/parallel_for.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <complex>
#include <numeric>
#include <tuple>

namespace slicemorph {

namespace {

using Complex = std::complex<double>;

constexpr int kSections = 65;
/// Of the penalty on third differences: waves shorter than a quarter of the axis are not followed.
constexpr double kSmooth = 30, kSmoothStart = 100;
/// Share of the axis, at each end, along which it grows stiffer towards the end.
constexpr double kEnd = 0.25;
/// How short the waves of the axis may be away from its ends, against those at the ends.
constexpr double kWaveInside = 0.5;
/// Bends of less than this, in radians over half the axis, tell no direction of their own.
constexpr double kLeastBend = 0.3;
/// An object shorter than this many times its width has no clear axis.
constexpr double kSlender = 1.8;
/// How many times as far an object must spread along its axis as across it, by standard deviation.
constexpr double kLong = 1.2;
/// Where slices come closer together than this the chart is of no use; how much of the object may lie there.
constexpr double kLeastSpread = 0.4, kMostCrossed = 0.01;
/// What the axis follows, in widths of its slices: how far from its end a slice is trusted wholly, and how
/// short a wave at an end may be. It begins stiff and grows supple, so that it neither folds nor curls on its
/// way; once it rests its ends are followed closer.
struct Grip {
  double cap, wave;
};
constexpr Grip kEarly{0.8, 0.35}, kLate{0.3, 0.25};
constexpr double kFirstWave = 1.5, kSuppler = 0.7;
constexpr int kRounds = 9, kLateRounds = 8;
/// An axis that moves by less than this from round to round, in widths, rests; one that moves by more than
/// the second with its ends followed closer has not found them.
constexpr double kRest = 0.002, kRestless = 0.02;
constexpr double kVolumeTolerance = 0.03;

/// Trust in a slice by its distance to the axis' end: near an end it may be cut askew by the end cap. `cap`:
/// in widths of the slice, where trust begins to fade.
double awayFromEnd(double distance, double area, double cap) {
  const double clear = std::min(distance / std::max(cap * std::sqrt(std::max(area, 0.0)), 1e-300), 1.0);
  return clear * clear * clear * clear;
}

/// Evenly spaced points of least third differences near the given ones, each as near as its weight tells.
std::vector<Vec3d> smoothed(const std::vector<Vec3d>& points, const std::vector<double>& weights) {
  const int n = int(points.size());
  Eigen::MatrixXd a = Eigen::MatrixXd::Zero(n, n), b(n, 3);
  for (int i = 0; i < n; ++i) {
    a(i, i) = weights[size_t(i)] + 1e-9;
    for (int d = 0; d < 3; ++d) b(i, d) = a(i, i) * points[size_t(i)][d];
  }
  const double third[4] = {-1, 3, -3, 1};
  for (int i = 0; i + 3 < n; ++i)
    for (int j = 0; j < 4; ++j)
      for (int k = 0; k < 4; ++k) a(i + j, i + k) += kSmoothStart * third[j] * third[k];
  const Eigen::MatrixXd x = a.ldlt().solve(b);
  std::vector<Vec3d> result;
  for (int i = 0; i < n; ++i) result.emplace_back(x(i, 0), x(i, 1), x(i, 2));
  return result;
}

/// `count` points evenly spaced along a smooth line through the given ones (Catmull-Rom).
std::vector<Vec3d> evenly(const std::vector<Vec3d>& line, int count) {
  const int n = int(line.size());
  std::vector<double> at{0};
  for (int i = 1; i < n; ++i) at.push_back(at.back() + (line[i] - line[i - 1]).length());
  const auto slope = [&](int i) {
    if (n < 3) return (line[n - 1] - line[0]) / at.back();
    const int m = std::min(std::max(i, 1), n - 2);
    const double h0 = std::max(at[m] - at[m - 1], 1e-300), h1 = std::max(at[m + 1] - at[m], 1e-300);
    const Vec3d before = (line[m] - line[m - 1]) / h0, after = (line[m + 1] - line[m]) / h1;
    const Vec3d here = (h1 * before + h0 * after) / (h0 + h1);
    return i < m ? 2.0 * before - here : i > m ? 2.0 * after - here : here;
  };
  std::vector<Vec3d> result;
  int i = 0;
  for (int k = 0; k < count; ++k) {
    const double s = at.back() * k / (count - 1);
    while (i + 2 < n && at[i + 1] < s) ++i;
    const double h = std::max(at[i + 1] - at[i], 1e-300), f = (s - at[i]) / h, g = 1 - f;
    result.push_back(g * g * (1 + 2 * f) * line[i] + f * f * (1 + 2 * g) * line[i + 1] +
                     h * f * g * (g * slope(i) - f * slope(i + 1)));
  }
  return result;
}

/// Turns and moves a chart whose spine has the right shape so that it lies best over evenly spaced points.
void layOver(Chart& chart, const std::vector<Vec3d>& points) {
  const int n = int(points.size());
  const auto weight = [&](int i) { return (i == 0 || i == n - 1 ? 0.5 : 1) / (n - 1); };
  const auto spine = [&](int i) {
    return chart.axes * (chart.scale[0] * chart.bend.at(2.0 * i / (n - 1) - 1).point);
  };
  Vec3d mean(0.0);
  for (int i = 0; i < n; ++i) mean += weight(i) * points[size_t(i)];
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Identity() * 1e-9 * chart.scale[0] * chart.scale[0];
  Eigen::Vector3d moment = Eigen::Vector3d::Zero();
  const Vec3d own = chart.axes * (chart.scale[0] * chart.bend.middle());
  for (int i = 0; i < n; ++i) {
    const Vec3d r = spine(i) - own, torque = r.cross(points[size_t(i)] - mean);
    const Eigen::Vector3d e(r[0], r[1], r[2]);
    inertia += weight(i) * (e.squaredNorm() * Eigen::Matrix3d::Identity() - e * e.transpose());
    moment += weight(i) * Eigen::Vector3d(torque[0], torque[1], torque[2]);
  }
  const Eigen::Vector3d turn = inertia.ldlt().solve(moment);
  chart.axes = rotationFromVector({turn[0], turn[1], turn[2]}) * chart.axes;
  chart.center = mean - chart.axes * (chart.scale[0] * chart.bend.middle());
}

/// Frames along evenly spaced points that do not spin (double reflection [WJZL08]), as a chart with
/// slices in world units.
Chart chartThrough(const std::vector<Vec3d>& points) {
  const int n = Bend::kStations;
  const std::vector<Vec3d> p = evenly(points, n);
  std::vector<Vec3d> tangent(n), side(n);
  for (int i = 1; i + 1 < n; ++i) tangent[i] = (p[i + 1] - p[i - 1]).unit();
  // A chord of an even bend lies midway between the directions at its ends.
  const auto mirrored = [](const Vec3d& t, const Vec3d& chord) {
    return 2 * t.dot(chord) / chord.lengthSqr() * chord - t;
  };
  tangent[0] = mirrored(tangent[1], p[1] - p[0]);
  tangent[n - 1] = mirrored(tangent[n - 2], p[n - 1] - p[n - 2]);
  side[0] = std::abs(tangent[0][0]) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  side[0] = (side[0] - side[0].dot(tangent[0]) * tangent[0]).unit();
  for (int i = 0; i + 1 < n; ++i) {
    const Vec3d v1 = p[i + 1] - p[i];
    const double c1 = v1.lengthSqr();
    const Vec3d s = side[i] - v1 * (2 / c1 * v1.dot(side[i])),
                t = tangent[i] - v1 * (2 / c1 * v1.dot(tangent[i]));
    const Vec3d v2 = tangent[i + 1] - t;
    const double c2 = v2.lengthSqr();
    side[i + 1] = c2 > 1e-30 ? s - v2 * (2 / c2 * v2.dot(s)) : s;
    side[i + 1] = (side[i + 1] - side[i + 1].dot(tangent[i + 1]) * tangent[i + 1]).unit();
  }
  std::vector<Mat3d> frame;
  for (int i = 0; i < n; ++i) {
    const Vec3d e2 = tangent[i].cross(side[i]);
    frame.emplace_back(tangent[i][0], side[i][0], e2[0], tangent[i][1], side[i][1], e2[1], tangent[i][2],
                       side[i][2], e2[2]);
  }
  const double spacing = 2.0 / (n - 1);
  std::vector<Vec3d> between, rates;
  for (int i = 0; i + 1 < n; ++i)
    between.push_back(rotationVector(frame[i].transpose() * frame[i + 1]) / spacing);
  for (int i = 0; i < n; ++i)
    rates.push_back(0.5 * (between[std::max(i - 1, 0)] + between[std::min(i, n - 2)]));
  rates.front() += 0.5 * (between[0] - between[1]), rates.back() += 0.5 * (between[n - 2] - between[n - 3]);
  double length = 0;
  for (int i = 0; i + 1 < n; ++i) length += (p[i + 1] - p[i]).length();
  Chart chart;
  chart.axes = frame[(n - 1) / 2];
  chart.scale = Vec3d(0.5 * length, 1, 1);
  chart.bend = Bend(1, std::move(rates));
  layOver(chart, p);
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
    if (weight[i] > 0)
      sum[i] /= weight[i];
    else
      sum[i] = mean;
    const double area = weight[i] * nodes.spacing * nodes.spacing * nodes.spacing / length;
    weight[i] = awayFromEnd(length * std::min(i, kSections - 1 - i), area, kTip);
  }
  return smoothed(sum, weight);
}

/// Chart coordinates of all nodes.
std::vector<Vec3d> inChart(const Chart& chart, const InsideNodes& nodes) {
  std::vector<Vec3d> z(nodes.position.size());
  tbb::parallel_for(size_t(0), z.size(), [&](size_t i) { z[i] = chart.toChart(nodes.position[i]); });
  return z;
}

/// From where to where along the chart's spine the object reaches. Each node's ball is inside, so it is
/// followed along the spine to the ball's end.
std::pair<double, double> extentOf(const Chart& chart, const InsideNodes& nodes,
                                   const std::vector<Vec3d>& z) {
  double low = 1e300, high = -1e300;
  const auto ballEnd = [&](size_t i, double sign) {
    const Mat3d frame = chart.axes * chart.bend.at(z[i][0]).frame;
    const Vec3d along(frame(0, 0), frame(1, 0), frame(2, 0));
    return chart.toChart(nodes.position[i] + (sign * nodes.depth[i]) * along)[0];
  };
  for (size_t i = 0; i < z.size(); ++i) {
    if (nodes.depth[i] >= 0) low = std::min(low, z[i][0]), high = std::max(high, z[i][0]);
  }
  for (size_t i = 0; i < z.size(); ++i) {
    // Where slices stand closer than this the object is no chart's.
    const double most = std::abs(nodes.depth[i]) / (kLeastSpread * chart.scale[0]);
    if (z[i][0] + most > high) high = std::max(high, ballEnd(i, 1));
    if (z[i][0] - most < low) low = std::min(low, ballEnd(i, -1));
  }
  return {low, high};
}

/// A chart's own slices, evenly from tip to tip.
struct Sections {
  double low = 0, high = 0;   ///< z0 of the first and the last one
  std::vector<Complex> away;  ///< from the spine to the slice's centroid, e1 + i e2, world units
  std::vector<double> trust, width;

  double place(int i) const { return low + (high - low) * i / (kSections - 1); }
};

Sections sectionsOf(const Chart& chart, const InsideNodes& nodes, double cap) {
  const std::vector<Vec3d> z = inChart(chart, nodes);
  Sections result;
  std::tie(result.low, result.high) = extentOf(chart, nodes, z);
  const double spacing = (result.high - result.low) / (kSections - 1);
  std::vector<double> area(kSections, 0);
  std::vector<Complex> moment(kSections, 0);
  for (size_t i = 0; i < z.size(); ++i) {
    const double u = (z[i][0] - result.low) / spacing;
    const int below = std::min(std::max(int(u), 0), kSections - 2);
    const double w = nodes.share[i] / std::max(chart.spread(z[i]), 0.3), f = u - below;
    for (int side = 0; side < 2; ++side) {
      const double v = w * (side ? f : 1 - f);
      area[below + side] += v, moment[below + side] += v * Complex(z[i][1], z[i][2]);
    }
  }
  area.front() *= 2, area.back() *= 2, moment.front() *= 2, moment.back() *= 2;
  // From volume per section to that of the slices.
  const double unit = nodes.spacing * nodes.spacing * nodes.spacing / (spacing * chart.scale[0]);
  for (int i = 0; i < kSections; ++i) {
    result.away.push_back(area[i] > 0 ? moment[i] / area[i] : 0);
    // Slices where the object ends or narrows suddenly, and those at an end cap, which are cut askew as long
    // as the axis is not right, are trusted least.
    double least = 1e300, most = 0;
    for (int j = std::max(i - 4, 0); j <= std::min(i + 4, kSections - 1); ++j)
      least = std::min(least, area[j]), most = std::max(most, area[j]);
    const double full = most > 0 ? least / most : 0;
    const double toEnd = std::min(i, kSections - 1 - i) * spacing * chart.scale[0];
    result.trust.push_back(full * full * awayFromEnd(toEnd, area[i] * unit, cap));
    result.width.push_back(std::sqrt(std::max(most * unit, 0.0)));
  }
  return result;
}

/// Bend of a chart's spine at its sections as a complex number, e1 + i e2, per world unit.
std::vector<Complex> bendAt(const Chart& chart, const Sections& sections) {
  const std::vector<Vec3d> rates = chart.bend.rates();
  std::vector<Complex> bend;
  for (int i = 0; i < kSections; ++i) {
    const double u = (sections.place(i) + 1) / 2 * (Bend::kStations - 1);
    const int j = std::min(std::max(int(u), 0), Bend::kStations - 2);
    const double f = std::min(std::max(u - j, 0.0), 1.0);
    const Vec3d rate = (1 - f) * rates[size_t(j)] + f * rates[size_t(j) + 1];
    bend.push_back(Complex(rate[2], -rate[1]) / chart.scale[0]);
  }
  return bend;
}

/// Turning of the bend's direction about the spine near section i, radians per section.
double windingAt(int i, const std::vector<Complex>& bend, const std::vector<double>& trust,
                 double leastBend) {
  constexpr int kWindow = 12;
  double turning = 0, all = kWindow * leastBend * leastBend;
  for (int j = std::max(i - kWindow, 1); j <= std::min(i + kWindow, kSections - 2); ++j) {
    turning += trust[size_t(j)] * 0.5 * ((bend[j + 1] - bend[j - 1]) * std::conj(bend[j])).imag();
    all += trust[size_t(j)] * std::norm(bend[j]);
  }
  return turning / all;
}

/// The axis through the centroids of the chart's own slices, each as near as its trust tells, that bends as
/// evenly as can be. Even is a screw's motion at a constant rate, for a bar may end in the midst of a bend or
/// a winding: d bend = i winding bend, in frames that do not spin. `wave`: see Grip.
std::vector<Vec3d> throughCentroids(const Chart& chart, const Sections& sections, double wave) {
  const int n = kSections;
  const double spacing = (sections.high - sections.low) / (n - 1) * chart.scale[0];
  const std::vector<Complex> bend = bendAt(chart, sections);
  Eigen::MatrixXcd a = Eigen::MatrixXcd::Zero(n, n);
  Eigen::VectorXcd b(n);
  for (int i = 0; i < n; ++i) {
    const double trust = sections.trust[size_t(i)];
    a(i, i) = trust + 1e-9, b[i] = trust * sections.away[size_t(i)];
  }
  for (int i = 0; i + 3 < n; ++i) {
    // A wave of w sections is stiff by its sixth power, as the penalty is on third differences.
    const double waves = wave * sections.width[size_t(i < n / 2 ? i : i + 3)] / spacing;
    const double inside = std::max(std::pow(kWaveInside * waves, 6), kSmooth);
    const double end = std::max(1 - std::min(i, n - 4 - i) / (kEnd * n), 0.0);
    const double stiffness = inside * std::pow(std::max(std::pow(waves, 6) / inside, 1.0), end);
    const Complex turn(0, windingAt(i + 1, bend, sections.trust, kLeastBend / chart.scale[0]));
    const Complex row[4] = {-1.0 - 0.5 * turn, 3.0 + 0.5 * turn, -3.0 + 0.5 * turn, 1.0 - 0.5 * turn};
    const Complex own =
        spacing * spacing * (bend[i + 2] - bend[i + 1] - 0.5 * turn * (bend[i + 1] + bend[i + 2]));
    for (int p = 0; p < 4; ++p) {
      for (int q = 0; q < 4; ++q) a(i + p, i + q) += stiffness * std::conj(row[p]) * row[q];
      b[i + p] -= stiffness * std::conj(row[p]) * own;
    }
  }
  const Eigen::VectorXcd x = a.ldlt().solve(b);
  std::vector<Vec3d> points;
  for (int i = 0; i < n; ++i) points.push_back(chart.toWorld({sections.place(i), x[i].real(), x[i].imag()}));
  return points;
}

/// Whether the object spreads clearly more along the spine than across it: a cube's diagonal or a ring's
/// diameter is no axis.
bool isLong(const Chart& chart, const InsideNodes& nodes, const std::vector<Vec3d>& z) {
  double all = 0, along = 0, first = 0, second = 0, mixed = 0;
  Vec3d mean(0.0);
  for (size_t i = 0; i < z.size(); ++i) all += nodes.share[i], mean += nodes.share[i] * z[i];
  mean /= all;
  for (size_t i = 0; i < z.size(); ++i) {
    const Vec3d d = chart.scale * (z[i] - mean);
    const double w = nodes.share[i] / all;
    along += w * d[0] * d[0], first += w * d[1] * d[1], second += w * d[2] * d[2], mixed += w * d[1] * d[2];
  }
  const double across = 0.5 * (first + second) + std::hypot(0.5 * (first - second), mixed);
  return along > kLong * kLong * across;
}

/// How far a spine has moved from another one, at most, world units.
double movedBetween(const Chart& a, const Chart& b) {
  double most = 0;
  for (int i = -8; i <= 8; ++i) {
    const Vec3d z(i / 8.0, 0, 0);
    most = std::max(most, (a.toWorld(z) - b.toWorld(z)).length());
  }
  return most;
}

/// Volume that the chart's slices count: once everywhere, if the chart is sound.
double countedVolume(const DistanceField& field, const Chart& chart, const std::vector<Vec3d>& inside) {
  openvdb::BBoxd box;
  for (const Vec3d& z : inside) box.expand(z);
  constexpr int kAlong = 96, kAcross = 48;
  const Vec3d margin = 0.1 * box.extents(), low = box.min() - margin, extent = box.extents() + 2.0 * margin;
  const Vec3d cell(extent[0] / kAlong, extent[1] / kAcross, extent[2] / kAcross);
  const double soft =
      std::max({chart.scale[0] * cell[0], chart.scale[1] * cell[1], chart.scale[2] * cell[2]});
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
  for (const Vec3d& p : nodes.position)
    low = std::min(low, (p - mean).dot(axis)), high = std::max(high, (p - mean).dot(axis));
  return {mean + low * axis, mean + high * axis};
}

/// The axis from a first guess; nothing where it is no sound chart of the object.
std::optional<Chart> settled(const DistanceField& field, const InsideNodes& nodes,
                             const std::vector<Vec3d>& start) {
  if (start.empty()) return std::nullopt;
  Chart chart = chartThrough(start);
  double moved = 0;
  const auto settle = [&](const Grip& grip, double firstWave, int rounds) {
    double wave = firstWave;
    for (int round = 0; round < rounds; ++round) {
      const Sections sections = sectionsOf(chart, nodes, grip.cap);
      const Chart next = chartThrough(throughCentroids(chart, sections, std::max(wave, grip.wave)));
      moved = movedBetween(chart, next) / std::sqrt(nodes.volume() / (2 * next.scale[0]));
      chart = next;
      if (moved < kRest && wave <= grip.wave) break;
      wave *= kSuppler;
    }
  };
  settle(kEarly, kFirstWave, kRounds);
  const Chart early = chart;
  settle(kLate, kLate.wave, kLateRounds);
  if (moved > kRestless) chart = early;
  const double volume = nodes.volume(), radius = std::sqrt(volume / (2 * chart.scale[0]));
  chart.scale[1] = chart.scale[2] = radius;
  if (!(2 * chart.scale[0] > kSlender * radius)) return std::nullopt;
  const std::vector<Vec3d> z = inChart(chart, nodes);
  if (!isLong(chart, nodes, z)) return std::nullopt;
  double crossed = 0, all = 0;
  for (size_t i = 0; i < z.size(); ++i) {
    all += nodes.share[i];
    if (chart.spread(z[i]) < kLeastSpread ||
        (chart.toWorld(z[i]) - nodes.position[i]).length() > 0.01 * radius)
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
