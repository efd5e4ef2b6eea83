#include "engine/frame/spine_frames.h"

#include "engine/frame/roll.h"
#include "engine/spine/fit_spine.h"

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace slicemorph {

namespace {

/// Distance from its chord, in radii of the object, below which an axis counts as straight. Chosen by hand.
constexpr double kLeastBow = 0.15;
/// Price in slice overlap of turning or bending by 90 degrees; as kSmallPrice in align.cpp.
constexpr double kTurnPrice = 0.02;
/// A roll that varies by less than this along the spine, radians, is not a twist of the object but
/// the drift of its rotation-minimising frames where the fitted spine is a little off, and is
/// corrected. Chosen by hand.
constexpr double kLeastTwist = 0.1;
/// Slice overlap that a twist must gain; from the method's prototype.
constexpr double kTwistGain = 0.03;

/// The roll of b's slices that minimises the rotation between the charts' middles.
double leastRoll(const Chart& a, const Chart& b) {
  const Mat3d m = a.axes.transpose() * b.axes;
  return std::atan2(m(1, 2) - m(2, 1), m(1, 1) + m(2, 2));
}

double turnBetween(const Chart& a, const Chart& b) {
  return rotationVector(a.axes.transpose() * b.axes).length();
}

/// The roll of b's slices for which b's bend agrees best with a's.
double bendRoll(const Chart& a, const Chart& b) {
  const std::vector<Vec3d> ra = a.bend.rates(), rb = b.bend.rates();
  double along = 0, across = 0;
  for (size_t i = 0; i < ra.size(); ++i) {
    along += ra[i][1] * rb[i][1] + ra[i][2] * rb[i][2];
    across += ra[i][1] * rb[i][2] - ra[i][2] * rb[i][1];
  }
  return std::atan2(across, along);
}

/// Total difference of the charts' bends along the spine, radians.
double bendBetween(const Chart& a, const Chart& b) {
  const std::vector<Vec3d> ra = a.bend.rates(), rb = b.bend.rates();
  double sum = 0;
  for (size_t i = 0; i < ra.size(); ++i) sum += (ra[i] - rb[i]).length() / double(ra.size());
  return 2 * std::max(a.bend.half(), b.bend.half()) * sum;
}

/// An object's chart whose slices overlap best with the first object's.
struct Laid {
  Chart steady;                  ///< with one roll for all slices
  std::optional<Chart> twisted;  ///< with a roll per slice, where that gains at least kTwistGain
  std::string twist;             ///< text of the note on the twist
};

/// `candidates`: b's chart, and the reversed one if that is to be tried.
Laid laidOn(const DistanceField& fieldA, const Chart& a, const DistanceField& fieldB,
            const std::vector<Chart>& candidates, double half) {
  Laid laid{candidates[0], {}, {}};
  double most = -1e300, mostAlong = -1e300, overlap = 0, overlapAlong = 0;
  for (const Chart& candidate : candidates)
    for (double preferred : {leastRoll(a, candidate), bendRoll(a, candidate)}) {
      const Roll roll = findRoll(fieldA, a, fieldB, candidate, half, preferred);
      const auto valueOf = [&](const Chart& chart, double agreement) {
        return agreement - kTurnPrice * (turnBetween(a, chart) + bendBetween(a, chart)) / (M_PI / 2);
      };
      const auto [least, greatest] = std::minmax_element(roll.along.begin(), roll.along.end());
      const bool small = *greatest - *least < kLeastTwist && roll.alongOverlap >= roll.steadyOverlap;
      // The middle slice keeps exactly the steady angle, so that an object that need not turn does not.
      std::vector<double> drift = roll.along;
      for (double& angle : drift) angle += roll.steady - roll.along[roll.along.size() / 2];
      const Chart steady = rolled(candidate, roll.steady), along = twisted(candidate, half, roll.along);
      if (const double v = valueOf(steady, roll.steadyOverlap); v > most)
        most = v, overlap = roll.steadyOverlap,
        laid.steady = small ? twisted(candidate, half, drift) : steady;
      if (const double v = valueOf(along, roll.alongOverlap); v > mostAlong) {
        mostAlong = v, overlapAlong = roll.alongOverlap, laid.twisted = along;
        char text[96];
        std::snprintf(text, sizeof text,
                      "twisted by %.0f degrees against the first: slices overlap %.2f, not",
                      (roll.along.back() - roll.along.front()) * 180 / M_PI, roll.alongOverlap);
        laid.twist = text;
      }
    }
  char text[16];
  std::snprintf(text, sizeof text, " %.2f", overlap);
  laid.twist += text;
  if (overlapAlong < overlap + kTwistGain) laid.twisted.reset();
  return laid;
}

/// Lays every object on the first. `candidates(k)`: the charts to try for object k.
template <typename Candidates>
LaidFrames laid(const Fields& fields, const std::vector<std::string>& names, const Frames& frames,
                const Candidates& candidates) {
  LaidFrames result{frames, frames};
  bool any = false;
  for (size_t k = 1; k < fields.size(); ++k) {
    const Laid one = laidOn(*fields[0], frames.charts[0], *fields[k], candidates(k), frames.halfLength);
    result.steady.charts[k] = one.steady;
    result.twisted->charts[k] = one.twisted.value_or(one.steady);
    if (one.twisted)
      any = true, result.twisted->notes.push_back({"frame.twisted", Severity::kNote, names[k], one.twist});
  }
  if (!any) result.twisted.reset();
  return result;
}

}  // namespace

std::optional<LaidFrames> framesAlongSpines(const Fields& fields, const std::vector<std::string>& names) {
  // One after the other: most objects have no spine, and then the others need none. Each fit is parallel.
  std::vector<FittedSpine> spines;
  double bow = 0, aspect = 0;
  for (const auto& field : fields) {
    const std::optional<FittedSpine> spine = fitSpine(*field);
    if (!spine) return std::nullopt;
    const FittedSpine& s = spines.emplace_back(*spine);
    bow = std::max(bow, s.bow);
    aspect += s.chart.scale[0] / s.chart.scale[1] / double(fields.size());
  }
  Frames frames;
  frames.halfLength = aspect;
  for (size_t k = 0; k < fields.size(); ++k) {
    Chart chart = spines[k].chart;
    chart.scale[0] /= aspect;
    std::vector<Vec3d> rates = chart.bend.rates();
    double turn = 0;
    for (Vec3d& r : rates) turn += r.length() * 2 / double(rates.size()), r /= aspect;
    chart.bend = Bend(aspect, std::move(rates));
    frames.charts.push_back(chart);
    char text[96];
    std::snprintf(text, sizeof text, "has a spine that turns by %.0f degrees in all", turn * 180 / M_PI);
    frames.notes.push_back({"frame.spine", Severity::kNote, names[k], text});
  }
  LaidFrames result = laid(fields, names, frames, [&](size_t k) {
    return std::vector<Chart>{frames.charts[k], reversed(frames.charts[k])};
  });
  result.bowed = bow >= kLeastBow;
  return result;
}

std::optional<Frames> twistedFrames(const Fields& fields, const std::vector<std::string>& names,
                                    const Frames& frames) {
  return laid(fields, names, frames, [&](size_t k) { return std::vector<Chart>{frames.charts[k]}; }).twisted;
}

}  // namespace slicemorph
