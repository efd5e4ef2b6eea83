#include "engine/frame/curved.h"

#include "engine/frame/roll.h"
#include "engine/spine/fit_spine.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {

namespace {

constexpr double kPi = 3.14159265358979323846;
/// An axis nearer to its chord than this, in radii, is as good as straight.
constexpr double kLeastBow = 0.15;
/// Overlap of the slices that turning or bending by 90 degrees must win.
constexpr double kTurnPrice = 0.02;
/// Overlap of the slices that twisting must win.
constexpr double kTwistGain = 0.03;

/// The roll of b's slices that turns its middle least against a's.
double leastRoll(const Chart& a, const Chart& b) {
  const Mat3d m = a.axes.transpose() * b.axes;
  return std::atan2(m(1, 2) - m(2, 1), m(1, 1) + m(2, 2));
}

double turnBetween(const Chart& a, const Chart& b) { return rotationVector(a.axes.transpose() * b.axes).length(); }

/// The roll of b's slices with which b bends most like a.
double likeBend(const Chart& a, const Chart& b) {
  const std::vector<Vec3d> ra = a.bend.rates(), rb = b.bend.rates();
  double along = 0, across = 0;
  for (size_t i = 0; i < ra.size(); ++i) {
    along += ra[i][1] * rb[i][1] + ra[i][2] * rb[i][2];
    across += ra[i][1] * rb[i][2] - ra[i][2] * rb[i][1];
  }
  return std::atan2(across, along);
}

/// How much one chart must be bent to become the other, radians in all.
double bendBetween(const Chart& a, const Chart& b) {
  const std::vector<Vec3d> ra = a.bend.rates(), rb = b.bend.rates();
  double sum = 0;
  for (size_t i = 0; i < ra.size(); ++i) sum += (ra[i] - rb[i]).length() / double(ra.size());
  return 2 * std::max(a.bend.half(), b.bend.half()) * sum;
}

/// b's chart, one way round or the other and rolled, as it lies best on a's.
Chart laidOn(const DistanceField& fieldA, const Chart& a, const DistanceField& fieldB, const Chart& b, double half) {
  Chart best = b;
  double most = -1e300;
  for (const Chart& way : {b, reversed(b)})
    for (double preferred : {leastRoll(a, way), likeBend(a, way)}) {
      const Roll roll = findRoll(fieldA, a, fieldB, way, half, preferred);
      const Chart chart = rolled(way, roll.steady);
      const double work = turnBetween(a, chart) + bendBetween(a, chart);
      const double value = roll.steadyOverlap - kTurnPrice * work / (kPi / 2);
      if (value > most) most = value, best = chart;
    }
  return best;
}

}  // namespace

std::optional<Frames> curvedFrames(const Fields& fields) {
  std::vector<std::optional<FittedSpine>> spines(fields.size());
  tbb::parallel_for(size_t(0), fields.size(), [&](size_t k) { spines[k] = fitSpine(*fields[k]); });
  double bow = 0;
  for (const auto& s : spines) {
    if (!s) return std::nullopt;
    bow = std::max(bow, s->bow);
  }
  if (bow < kLeastBow) return std::nullopt;
  double aspect = 0;
  for (const auto& s : spines) aspect += s->chart.scale[0] / s->chart.scale[1] / double(fields.size());
  Frames frames;
  frames.halfLength = aspect;
  for (const auto& s : spines) {
    Chart chart = s->chart;
    chart.scale[0] /= aspect;
    std::vector<Vec3d> rates = chart.bend.rates();
    for (Vec3d& r : rates) r /= aspect;
    chart.bend = Bend(aspect, std::move(rates));
    frames.charts.push_back(chart);
  }
  for (size_t k = 1; k < fields.size(); ++k)
    frames.charts[k] = laidOn(*fields[0], frames.charts[0], *fields[k], frames.charts[k], aspect);
  for (size_t k = 0; k < fields.size(); ++k) {
    double turn = 0;
    const std::vector<Vec3d> rates = frames.charts[k].bend.rates();
    for (const Vec3d& r : rates) turn += r.length() * 2 * aspect / double(rates.size());
    char text[96];
    std::snprintf(text, sizeof text, "shape %zu has a curved spine that turns by %.0f degrees in all", k + 1, turn * 180 / kPi);
    frames.notes.push_back(text);
  }
  return frames;
}

std::optional<Frames> twistedFrames(const Fields& fields, const Frames& frames) {
  Frames result = frames;
  bool any = false;
  for (size_t k = 1; k < fields.size(); ++k) {
    const Roll roll = findRoll(*fields[0], frames.charts[0], *fields[k], frames.charts[k], frames.halfLength,
                               leastRoll(frames.charts[0], frames.charts[k]));
    if (roll.alongOverlap < roll.steadyOverlap + kTwistGain) continue;
    any = true;
    result.charts[k] = twisted(frames.charts[k], frames.halfLength, roll.along);
    char text[128];
    std::snprintf(text, sizeof text, "shape %zu twisted by %.0f degrees against the first: slices overlap %.2f, not %.2f",
                  k + 1, (roll.along.back() - roll.along.front()) * 180 / kPi, roll.alongOverlap, roll.steadyOverlap);
    result.notes.push_back(text);
  }
  if (!any) return std::nullopt;
  return result;
}

}  // namespace slicemorph
