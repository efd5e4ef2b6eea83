#include "engine/match/choose_frames.h"

#include "engine/frame/feature_turns.h"
#include "engine/frame/spine_frames.h"
#include "engine/match/register.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cstdio>

namespace slicemorph {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kQuickSlices = 32;
/// What curved spines or a twist must win: they are for objects that clearly need them.
constexpr double kPrice = 0.03;
/// What strain costs: anything can be matched with anything, a head with a tail, but only by bending it.
constexpr double kStrainPrice = 0.5;

/// What features may leave over more than the best turn for them does, for a turn that the shapes suggest to
/// be good enough.
constexpr double kFeatureSlack = 0.3;

/// The turns worth trying from one object to another. Features rule out what goes against them, and suggest
/// their own turn where that leaves none.
std::vector<Turn> turnsToTry(const Fields& pair, const std::vector<Vec3d>& from, const std::vector<Vec3d>& to,
                             const Vec3d& up) {
  std::vector<Turn> turns = proposeTurns(*pair[0], *pair[1], up);
  const std::vector<Mat3d> prescribed = turnsOf(from, to);
  if (prescribed.empty()) return turns;
  double best = misfit(from, to, prescribed[0]);
  for (const Mat3d& rotation : prescribed) best = std::min(best, misfit(from, to, rotation));
  turns.erase(
      std::remove_if(turns.begin(), turns.end(),
                     [&](const Turn& t) { return misfit(from, to, t.rotation) > best + kFeatureSlack; }),
      turns.end());
  if (turns.empty())
    for (const Mat3d& rotation : prescribed)
      turns.push_back({rotation, rotationVector(rotation).length(), 0});
  return turns;
}

/// The turn from the first object of a pair to the other one.
Turn chooseTurn(const Fields& pair, const std::vector<Turn>& turns, const MorphOptions& options,
                Progress& progress) {
  if (turns.size() == 1) return turns[0];
  const Turn* best = nullptr;
  double most = -1e30;
  for (const Turn& turn : turns) {
    if (1 - priceOf(turn.rotation, options.up) <= most) continue;  // no overlap is above 1
    const Frames frames = frameObjects(pair, {Mat3d::identity(), turn.rotation}, options);
    const Agreement reached = quickAgreement(pair, frames, options, progress);
    const double value = reached.after - kStrainPrice * reached.strain - priceOf(turn.rotation, options.up);
    if (value > most) most = value, best = &turn;
  }
  return *best;
}

/// Price of all the objects' turns against the first.
double turnPrice(const Frames& frames, const Vec3d& up) {
  double price = 0;
  for (size_t k = 1; k < frames.charts.size(); ++k)
    price += priceOf(frames.charts[k].axes * frames.charts[0].axes.transpose(), up);
  return price / double(std::max<size_t>(frames.charts.size() - 1, 1));
}

Frames straightFrames(const Fields& fields, const std::vector<std::string>& names,
                      const MorphOptions& options, Progress& progress) {
  std::vector<Mat3d> rotations(fields.size(), Mat3d::identity());
  Notes notes;
  for (size_t k = 1; k < fields.size() && options.align != Align::kNone; ++k) {
    // Only two shapes are looked at here, and the features tell of all.
    MorphOptions pairOptions = options;
    pairOptions.features.clear();
    const Fields pair{fields[0], fields[k]};
    const std::vector<Turn> turns =
        turnsToTry(pair, placesOn(options.features, 0), placesOn(options.features, k), options.up);
    const Turn turn = chooseTurn(pair, turns, pairOptions, progress);
    rotations[k] = turn.rotation;
    const double degrees = turn.angle * 180 / kPi;
    char text[256];
    if (turn.overlap == 0)
      std::snprintf(text, sizeof text, "%s turned by %.1f degrees against %s, as features tell",
                    names[k].c_str(), degrees, names[0].c_str());
    else if (degrees > 0)
      std::snprintf(text, sizeof text, "%s turned by %.1f degrees against %s, overlap %.2f before warping",
                    names[k].c_str(), degrees, names[0].c_str(), turn.overlap);
    else
      std::snprintf(text, sizeof text, "%s keeps its directions, overlap %.2f before warping",
                    names[k].c_str(), turn.overlap);
    notes.push_back(text);
  }
  Frames frames = frameObjects(fields, rotations, options);
  frames.notes.insert(frames.notes.begin(), notes.begin(), notes.end());
  return frames;
}

}  // namespace

Frames chooseFrames(const Fields& fields, const std::vector<std::string>& names, const MorphOptions& options,
                    Progress& progress) {
  MorphOptions quick = options;
  quick.slices = kQuickSlices;
  Frames best = straightFrames(fields, names, quick, progress);
  if (options.align == Align::kNone) return best;
  Agreement least = quickAgreement(fields, best, quick, progress);
  // No overlap is above 1 and no price below 0: what cannot win is not tried.
  const auto mayWin = [&] {
    return 0.5 * (2 - least.before - least.after) + turnPrice(best, options.up) > kPrice;
  };
  const auto consider = [&](const std::optional<Frames>& frames, const char* name, bool wanted = false) {
    if (!frames) return;
    const Agreement a = quickAgreement(fields, *frames, quick, progress);
    const double gain = 0.5 * (a.before + a.after - least.before - least.after) +
                        turnPrice(best, options.up) - turnPrice(*frames, options.up);
    const bool wins = wanted || (gain > kPrice && a.after > least.after - kPrice);
    char text[128];
    std::snprintf(text, sizeof text,
                  "%s %s: overlap %.3f before and %.3f after a quick matching, else %.3f and %.3f", name,
                  wins ? "taken" : "not taken", a.before, a.after, least.before, least.after);
    if (wins) best = *frames, least = a;
    best.notes.push_back(text);
  };
  if (mayWin()) consider(twistedFrames(fields, names, best), "twist");
  const bool wanted = options.spine == SpineKind::kCurved;
  if (!wanted && (options.spine == SpineKind::kStraight || options.axis.length() > 0 || !mayWin()))
    return best;
  if (const std::optional<LaidFrames> own = framesAlongSpines(fields, names)) {
    if (own->bowed || wanted) consider(own->steady, "curved spine", wanted);
    consider(own->twisted, own->bowed ? "curved spine with twist" : "own spine with twist");
  } else if (wanted) {
    best.notes.push_back("not every shape has a sound curved spine: straight ones are used");
  }
  return best;
}

}  // namespace slicemorph
