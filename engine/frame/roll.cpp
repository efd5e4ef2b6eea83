#include "engine/frame/roll.h"

#include <tbb/parallel_for.h>
#include <Eigen/Cholesky>
#include <Eigen/Core>

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slicemorph {

namespace {

// The figures are chosen by hand; tests/engine/spine/bend_test.cpp guards twists,
// tests/engine/morph_test.cpp round shapes.

/// Slices along the spine; steps of angle (3 degrees) and rings of a slice in polar coordinates.
constexpr int kSlices = 33, kAngles = 120, kRings = 10;
constexpr int kFastest = 4;  ///< largest change of angle from slice to slice, in steps
/// Price in overlap of a change by one step (squared) from slice to slice.
constexpr double kStepPrice = 0.0005;
/// Price in overlap of an angle half a turn away from the preferred one.
constexpr double kAnglePrice = 0.02;
/// Slices are round where the overlap falls, within four steps on both sides of the best angle, by less
/// than this in the mean.
constexpr double kLeastFall = 0.01;

/// One slice in polar coordinates about its centroid.
struct PolarSlice {
  std::vector<float> inside;  ///< share inside, ring by ring, kAngles each, weighted by the ring's radius
  double area = 0;            ///< chart units squared
};

/// Share inside at a chart point, with a ramp of `soft` chart units.
double insideAt(const DistanceField& field, const DistanceField::Sampler& sampler, const Chart& chart,
                const Vec3d& z, double soft) {
  if (chart.spread(z) <= 0) return 0;
  const double d = sampler.coarse(field.relative(chart.toWorld(z))) / (chart.meanScale() * soft);
  return std::min(std::max(0.5 - d, 0.0), 1.0);
}

PolarSlice polarSlice(const DistanceField& field, const Chart& chart, double z0, double reach) {
  const DistanceField::Sampler sampler(field);
  constexpr int kAcross = 32;
  const double cell = 2 * reach / kAcross;
  PolarSlice slice;
  Vec3d middle(z0, 0, 0);
  for (int i = 0; i < kAcross; ++i)
    for (int j = 0; j < kAcross; ++j) {
      const Vec3d z(z0, (i + 0.5) * cell - reach, (j + 0.5) * cell - reach);
      const double w = insideAt(field, sampler, chart, z, cell);
      slice.area += w * cell * cell;
      middle[1] += w * z[1], middle[2] += w * z[2];
    }
  if (slice.area > 0) {
    const double cells = slice.area / (cell * cell);
    middle[1] /= cells, middle[2] /= cells;
  }
  slice.inside.resize(kRings * kAngles);
  for (int r = 0; r < kRings; ++r)
    for (int a = 0; a < kAngles; ++a) {
      const double radius = (r + 0.5) * reach / kRings, angle = 2 * M_PI * a / kAngles;
      const Vec3d z = middle + radius * Vec3d(0, std::cos(angle), std::sin(angle));
      slice.inside[size_t(r * kAngles + a)] =
          float(radius * insideAt(field, sampler, chart, z, 0.5 * reach / kRings));
    }
  return slice;
}

/// Intersection over union when a's angles are increased by `step`.
double overlapOf(const PolarSlice& a, const PolarSlice& b, int step) {
  double both = 0, either = 0;
  for (int r = 0; r < kRings; ++r)
    for (int i = 0; i < kAngles; ++i) {
      const float p = a.inside[size_t(r * kAngles + i)],
                  q = b.inside[size_t(r * kAngles + (i + step) % kAngles)];
      both += std::min(p, q), either += std::max(p, q);
    }
  return either > 0 ? both / either : 0;
}

double wrapped(double angle) { return angle - 2 * M_PI * std::round(angle / (2 * M_PI)); }

/// Steps from one angle of the circle to another, the short way.
int stepsBetween(int from, int to) {
  const int d = ((to - from) % kAngles + kAngles) % kAngles;
  return d > kAngles / 2 ? d - kAngles : d;
}

/// Offset of the peak from the highest value v[s], in steps, -1 to 1: where the flanks are symmetric, which
/// holds for round peaks and for pointed ones, as of slices with straight sides.
double peakBeside(const std::vector<double>& v, int s) {
  const auto at = [&](int d) { return v[size_t((s + d + kAngles) % kAngles)]; };
  const double lean = at(2) + at(1) - at(-1) - at(-2), fall = at(-1) - at(-2) + at(1) - at(2);
  return fall > 1e-9 ? std::min(std::max(0.5 * lean / fall, -1.0), 1.0) : 0;
}

/// Overlap of the slices at each step of angle.
struct RollScores {
  std::vector<std::vector<double>> score;  ///< per slice and step: overlap when a is turned by that step
  std::vector<double> weight;              ///< per slice: geometric mean of the two areas
  double total = 0;                        ///< sum of the weights
  std::vector<double> price;               ///< per step: for its distance from the preferred angle
};

RollScores scoresOf(const std::vector<PolarSlice>& a, const std::vector<PolarSlice>& b, double preferred) {
  RollScores scores;
  scores.score.assign(kSlices, std::vector<double>(kAngles));
  scores.weight.resize(kSlices);
  tbb::parallel_for(0, kSlices, [&](int i) {
    for (int s = 0; s < kAngles; ++s)
      scores.score[size_t(i)][size_t(s)] = overlapOf(a[size_t(i)], b[size_t(i)], s);
    scores.weight[size_t(i)] = std::sqrt(a[size_t(i)].area * b[size_t(i)].area);
  });
  for (double w : scores.weight) scores.total += w;
  for (int s = 0; s < kAngles; ++s) {
    const double away = std::abs(wrapped(2 * M_PI * s / kAngles - preferred)) / M_PI;
    scores.price.push_back(kAnglePrice * away);
  }
  return scores;
}

/// A roll with the best single angle for all slices; `along` is not set.
Roll steadyRoll(const RollScores& scores, double preferred) {
  const std::vector<double>& price = scores.price;
  std::vector<double> mean(kAngles, 0);
  for (int s = 0; s < kAngles; ++s)
    for (int i = 0; i < kSlices; ++i)
      mean[size_t(s)] += scores.weight[size_t(i)] * scores.score[size_t(i)][size_t(s)] / scores.total;
  int best = 0;
  for (int s = 1; s < kAngles; ++s)
    if (mean[size_t(s)] - price[size_t(s)] > mean[size_t(best)] - price[size_t(best)]) best = s;
  Roll roll;
  roll.steady = 2 * M_PI / kAngles * (best + peakBeside(mean, best));
  roll.steadyOverlap = mean[size_t(best)];
  // On round slices no angle is better than another: use exactly the preferred one.
  const auto [least, most] = std::minmax_element(mean.begin(), mean.end());
  if (*most - *least < kAnglePrice) roll.steady = preferred;
  return roll;
}

/// The best sequence of angle steps, one per slice, by dynamic programming along the spine.
std::vector<int> bestSteps(const RollScores& scores) {
  std::vector<std::vector<double>> value(kSlices, std::vector<double>(kAngles));
  std::vector<std::vector<int>> from(kSlices, std::vector<int>(kAngles, 0));
  for (int i = 0; i < kSlices; ++i)
    for (int s = 0; s < kAngles; ++s) {
      double before = 0;
      if (i > 0) {
        before = -1e300;
        for (int d = -kFastest; d <= kFastest; ++d) {
          const int p = (s + d + kAngles) % kAngles;
          const double v = value[size_t(i) - 1][size_t(p)] - kStepPrice * d * d;
          if (v > before) before = v, from[size_t(i)][size_t(s)] = p;
        }
      }
      const double own =
          scores.weight[size_t(i)] / scores.total * scores.score[size_t(i)][size_t(s)] * kSlices;
      value[size_t(i)][size_t(s)] = before + own - (i == kSlices / 2 ? scores.price[size_t(s)] : 0);
    }
  std::vector<int> path(kSlices);
  path.back() = int(std::max_element(value.back().begin(), value.back().end()) - value.back().begin());
  for (int i = kSlices - 1; i > 0; --i) path[size_t(i) - 1] = from[size_t(i)][size_t(path[size_t(i)])];
  return path;
}

/// The slices' best angles.
struct SliceAngles {
  std::vector<double> angle, trust;  ///< radians, without jumps of 2 pi; weight in the smoothing
  double overlap = 0;                ///< mean overlap of the slices so turned
};

SliceAngles anglesAlong(const RollScores& scores, const std::vector<int>& path) {
  SliceAngles result;
  int steps = 0;
  for (int i = 0; i < kSlices; ++i) {
    const int s = path[size_t(i)];
    const std::vector<double>& score = scores.score[size_t(i)];
    const double here = score[size_t(s)], weight = scores.weight[size_t(i)];
    steps += i == 0 ? s : stepsBetween(path[size_t(i) - 1], s);
    result.angle.push_back(2 * M_PI / kAngles * (steps + peakBeside(score, s)));
    result.overlap += weight * here / scores.total;
    // A slice's angle is trusted by how much the overlap falls on both sides of it.
    const double fall =
        here - 0.5 * (score[size_t((s + 4) % kAngles)] + score[size_t((s + kAngles - 4) % kAngles)]);
    result.trust.push_back(weight * kSlices / scores.total * std::max(fall, 0.0));
  }
  return result;
}

/// Angles at Bend's stations: least squares to the slices' angles, weighted by trust, with a penalty
/// on second differences.
std::vector<double> smoothAngles(const SliceAngles& slices) {
  const int n = Bend::kStations;
  Eigen::MatrixXd m = Eigen::MatrixXd::Zero(n, n);
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(n);
  for (int i = 0; i < kSlices; ++i) {
    const double u = ((i + 0.5) / kSlices) * (n - 1);
    const int k = std::min(int(u), n - 2);
    const double f = u - k, w[2] = {1 - f, f};
    const double trust = slices.trust[size_t(i)] + 1e-6;
    for (int p = 0; p < 2; ++p) {
      for (int q = 0; q < 2; ++q) m(k + p, k + q) += trust * w[p] * w[q];
      rhs[k + p] += trust * w[p] * slices.angle[size_t(i)];
    }
  }
  const double second[3] = {1, -2, 1};
  constexpr double kStiff = 30;  // by hand
  for (int i = 0; i + 2 < n; ++i)
    for (int p = 0; p < 3; ++p)
      for (int q = 0; q < 3; ++q) m(i + p, i + q) += kStiff * second[p] * second[q];
  const Eigen::VectorXd x = m.ldlt().solve(rhs);
  return {x.data(), x.data() + n};
}

}  // namespace

Roll findRoll(const DistanceField& a, const Chart& chartA, const DistanceField& b, const Chart& chartB,
              double half, double preferred) {
  std::vector<PolarSlice> sa(kSlices), sb(kSlices);
  const auto position = [&](int i) { return half * ((i + 0.5) * 2 / kSlices - 1); };
  // The mean slice has area 1 in chart units, as a circle of radius 0.56; flat slices reach further.
  constexpr double kReach = 1.3;
  tbb::parallel_for(0, kSlices, [&](int i) {
    sa[size_t(i)] = polarSlice(a, chartA, position(i), kReach);
    sb[size_t(i)] = polarSlice(b, chartB, position(i), kReach);
  });
  const RollScores scores = scoresOf(sa, sb, preferred);
  Roll roll;
  roll.along.assign(Bend::kStations, 0);
  if (!(scores.total > 0)) return roll;
  roll = steadyRoll(scores, preferred);
  const SliceAngles slices = anglesAlong(scores, bestSteps(scores));
  roll.alongOverlap = slices.overlap;
  // Round slices determine no angle.
  const double trust = std::accumulate(slices.trust.begin(), slices.trust.end(), 0.0) / kSlices;
  if (trust < kLeastFall)
    roll.along.assign(Bend::kStations, roll.steady);
  else
    roll.along = smoothAngles(slices);
  return roll;
}

Chart twisted(const Chart& chart, double half, const std::vector<double>& angles) {
  const int n = Bend::kStations;
  Chart result = chart;
  const double spacing = 2 * half / (n - 1), middle = angles[size_t(n - 1) / 2];
  std::vector<Vec3d> rates = chart.bend.rates();
  for (int i = 0; i < n; ++i) {
    rates[size_t(i)] = rotationFromVector({-angles[size_t(i)], 0, 0}) * rates[size_t(i)];
    const int a = std::max(i - 1, 0), b = std::min(i + 1, n - 1);
    rates[size_t(i)][0] += (angles[size_t(b)] - angles[size_t(a)]) / ((b - a) * spacing);
  }
  result.axes = chart.axes * rotationFromVector({middle, 0, 0});
  result.bend = Bend(half, std::move(rates));
  return result;
}

}  // namespace slicemorph
