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

// Unless noted the figures are chosen by hand; tests/engine/spine/bend_test.cpp compares fitted spines with
// closed forms, and Curved.RoundAndStoutShapesStayStraight guards what has no axis.

/// Slices along the axis; as in the method's prototype.
constexpr int kSections = 65;
/// Least stiffness of the penalty on third differences, and the stiffness for the first guess: variations
/// shorter than about a quarter of the axis are smoothed out.
constexpr double kSmooth = 30, kSmoothStart = 100;
/// Share of the axis, at each end, along which the stiffness grows towards the end.
constexpr double kEnd = 0.25;
/// Wavelength that the axis may follow away from its ends, relative to that at the ends.
constexpr double kWaveInside = 0.5;
/// Bends of less than this, in radians over half the axis, have no reliable direction.
constexpr double kLeastBend = 0.3;
/// Least ratio of an axis' length to the root of the mean slice area.
constexpr double kSlender = 1.8;
/// Least ratio of the object's standard deviations along and across the axis.
constexpr double kLong = 1.2;
/// Spread of the slices (Chart::spread) below which a chart is unusable, as in the method's prototype; and
/// the largest share of the object where that may be so.
constexpr double kLeastSpread = 0.4, kMostCrossed = 0.01;
/// How closely the axis follows the centroids, in widths of its slices. It begins stiff and is made more
/// flexible from round to round, so that it neither folds nor curls; once it has converged its ends are
/// followed more closely. `cap`: distance from the axis' end from which a slice is fully trusted; `wave`:
/// shortest wavelength at an end.
struct Grip {
  double cap, wave;
};
constexpr Grip kEarly{0.8, 0.35}, kLate{0.3, 0.25};
/// The first round's wavelength, and its factor from round to round.
constexpr double kFirstWave = 1.5, kSuppler = 0.7;
/// Most rounds with kEarly and with kLate.
constexpr int kRounds = 9, kLateRounds = 8;
/// An axis that moves by less than kRest from round to round, in roots of the mean slice area, has converged;
/// if the last round with kLate still moves it by more than kRestless, the result of kEarly is kept.
constexpr double kRest = 0.002, kRestless = 0.02;
/// Largest relative error of the volume that the chart's slices count; the method's prototype had 0.02.
constexpr double kVolumeTolerance = 0.03;

/// Trust in a slice by its distance to the axis' end, world units: near the end it may cut the end cap askew.
/// `cap`: in widths of the slice, below which trust fades.
double awayFromEnd(double distance, double area, double cap) {
  const double clear = std::min(distance / std::max(cap * std::sqrt(std::max(area, 0.0)), 1e-300), 1.0);
  return clear * clear * clear * clear;
}

/// Evenly spaced points that minimise the weighted squared distances to the given ones and
/// the third differences.
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
  result.reserve(points.size());
  for (int i = 0; i < n; ++i) result.emplace_back(x(i, 0), x(i, 1), x(i, 2));
  return result;
}

/// `count` points evenly spaced along a cubic Hermite spline through the given ones, its slopes
/// by finite differences.
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

/// Rotates and moves a chart so that its spine fits evenly spaced points in least squares (small rotations).
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

/// Whether a curve through the points has a direction at each: neighbours differ, and so do those next to them.
bool hasDirections(const std::vector<Vec3d>& p) {
  for (size_t i = 0; i + 1 < p.size(); ++i)
    if (p[i + 1] == p[i] || (i > 0 && p[i + 1] == p[i - 1])) return false;
  return true;
}

/// A chart whose spine passes through the points, with rotation-minimising frames (double reflection
/// [WJZL08]); z0 in [-1, 1], slices in world units. None where the points have run into each other, as they do in
/// objects of a few voxels.
std::optional<Chart> chartThrough(const std::vector<Vec3d>& points) {
  const int n = Bend::kStations;
  const std::vector<Vec3d> p = evenly(points, n);
  if (!hasDirections(p)) return std::nullopt;
  std::vector<Vec3d> tangent(n), side(n);
  for (int i = 1; i + 1 < n; ++i) tangent[i] = (p[i + 1] - p[i - 1]).unit();
  // In an arc of constant curvature the chord lies midway between the tangents at its ends.
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

/// A first guess of the axis: centroids of the nodes binned by the difference of their geodesic distances to
/// the object's two ends. Empty where less than 97 % of the inside is connected.
std::vector<Vec3d> geodesicStart(const InsideNodes& nodes) {
  const Geodesics geodesics(nodes);
  size_t middle = 0;
  Vec3d mean(0.0);
  for (const Vec3d& p : nodes.position) mean += p / double(nodes.position.size());
  for (size_t i = 0; i < nodes.position.size(); ++i)
    if ((nodes.position[i] - mean).lengthSqr() < (nodes.position[middle] - mean).lengthSqr()) middle = i;
  const Geodesics::Distances distancesFromA = geodesics.from(geodesics.from(middle).farthest());
  const std::vector<double>& fromA = distancesFromA.length;
  const std::vector<double> fromB = geodesics.from(distancesFromA.farthest()).length;
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
  // Near the tips geodesic distances form spheres about the tip and do not show the axis.
  constexpr double kTip = 1.2;  // by hand, see awayFromEnd
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

/// Extent (low, high) of the object along the chart's spine, z0. The ball about a node with its depth as
/// radius is inside, so the extent includes the balls.
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
    // Bound on the ball's extent: charts with less spread are rejected anyway.
    const double most = std::abs(nodes.depth[i]) / (kLeastSpread * chart.scale[0]);
    if (z[i][0] + most > high) high = std::max(high, ballEnd(i, 1));
    if (z[i][0] - most < low) low = std::min(low, ballEnd(i, -1));
  }
  return {low, high};
}

/// A chart's slices, evenly spaced from tip to tip.
struct Sections {
  double low = 0, high = 0;          ///< z0 of the first and the last one
  std::vector<Complex> away;         ///< from the spine to the slice's centroid, e1 + i e2, world units
  std::vector<double> trust, width;  ///< weight of the centroid; root of the largest area nearby, world units

  double z0(int i) const { return low + (high - low) * i / (kSections - 1); }
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
  // Converts volume per section to area.
  const double unit = nodes.spacing * nodes.spacing * nodes.spacing / (spacing * chart.scale[0]);
  for (int i = 0; i < kSections; ++i) {
    result.away.push_back(area[i] > 0 ? moment[i] / area[i] : 0);
    // Slices where the object ends or narrows suddenly are trusted least, and so are those at an end cap,
    // which are askew as long as the axis is not right.
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

/// Curvature of a chart's spine at its sections as a complex number, e1 + i e2, per world unit.
std::vector<Complex> bendAt(const Chart& chart, const Sections& sections) {
  const std::vector<Vec3d> rates = chart.bend.rates();
  std::vector<Complex> bend;
  for (int i = 0; i < kSections; ++i) {
    const double u = (sections.z0(i) + 1) / 2 * (Bend::kStations - 1);
    const int j = std::min(std::max(int(u), 0), Bend::kStations - 2);
    const double f = std::min(std::max(u - j, 0.0), 1.0);
    const Vec3d rate = (1 - f) * rates[size_t(j)] + f * rates[size_t(j) + 1];
    bend.push_back(Complex(rate[2], -rate[1]) / chart.scale[0]);
  }
  return bend;
}

/// Torsion: turning of the bend's direction about the spine near section i, radians per section.
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

/// The axis through the centroids of the chart's slices, weighted by trust, that bends as evenly as possible.
/// Evenly means as a helix, of constant curvature and torsion (d bend = i winding bend in rotation-minimising
/// frames), since a bar may end in the middle of a bend or a winding. `wave`: see Grip.
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
    // The penalty on third differences suppresses waves of w sections if it is of the order w^6.
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
  points.reserve(size_t(n));
  for (int i = 0; i < n; ++i) points.push_back(chart.toWorld({sections.z0(i), x[i].real(), x[i].imag()}));
  return points;
}

/// Whether the object extends clearly further along the spine than across it, unlike along a cube's diagonal
/// or a ring's diameter.
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

/// Largest distance between two spines at equal z0, world units.
double movedBetween(const Chart& a, const Chart& b) {
  double most = 0;
  for (int i = -8; i <= 8; ++i) {
    const Vec3d z(i / 8.0, 0, 0);
    most = std::max(most, (a.toWorld(z) - b.toWorld(z)).length());
  }
  return most;
}

/// Volume of the object as integrated in chart space, world units cubed: equals the true one if the slices
/// cover the object exactly once. `inside`: chart coordinates of the nodes inside.
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

/// Largest distance of the spine from the line between its ends, world units.
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

/// Fits the axis from a first guess; nothing where it gives no valid chart of the object.
std::optional<Chart> settled(const DistanceField& field, const InsideNodes& nodes,
                             const std::vector<Vec3d>& start) {
  if (start.empty()) return std::nullopt;
  const std::optional<Chart> first = chartThrough(start);
  if (!first) return std::nullopt;
  Chart chart = *first;
  double moved = 0;
  // False where the axis is lost.
  const auto settle = [&](const Grip& grip, double firstWave, int rounds) {
    double wave = firstWave;
    for (int round = 0; round < rounds; ++round) {
      const Sections sections = sectionsOf(chart, nodes, grip.cap);
      const std::optional<Chart> next =
          chartThrough(throughCentroids(chart, sections, std::max(wave, grip.wave)));
      if (!next) return false;
      moved = movedBetween(chart, *next) / std::sqrt(nodes.volume() / (2 * next->scale[0]));
      chart = *next;
      if (moved < kRest && wave <= grip.wave) break;
      wave *= kSuppler;
    }
    return true;
  };
  if (!settle(kEarly, kFirstWave, kRounds)) return std::nullopt;
  const Chart early = chart;
  if (!settle(kLate, kLate.wave, kLateRounds)) return std::nullopt;
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
  // Of two valid axes take the shorter: the longer one may curl up at an end.
  for (const std::vector<Vec3d>& start : {straightStart(nodes), geodesicStart(nodes)}) {
    const std::optional<Chart> chart = settled(field, nodes, start);
    if (chart && (!best || chart->scale[0] < best->scale[0])) best = chart;
  }
  if (!best) return std::nullopt;
  return FittedSpine{*best, distanceFromChord(*best) / best->scale[1]};
}

}  // namespace slicemorph
