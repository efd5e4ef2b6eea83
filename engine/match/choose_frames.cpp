#include "engine/match/choose_frames.h"

#include "engine/frame/feature_turns.h"
#include "engine/frame/spine_frames.h"
#include "engine/match/agreement.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace slicemorph {

namespace {

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

/// The turn from the first object of a pair to the other one. Where no agreement is a number, as of shapes
/// without any inside, the most likely turn.
Turn chooseTurn(const Fields& pair, const std::vector<Turn>& turns, const MorphOptions& options,
                const Progress& progress) {
  if (turns.size() == 1) return turns[0];
  const Turn* best = &turns[0];
  double most = -1e30;
  for (const Turn& turn : turns) {
    if (progress.cancelled()) throw Cancelled();
    if (1 - priceOf(turn.rotation, options.up) <= most) continue;  // no overlap is above 1
    const Frames frames = frameObjects(pair, {Mat3d::identity(), turn.rotation}, options);
    const Agreement reached = quickAgreement(pair, frames, options);
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

/// What was decided of an object's turn against the first one, `first`.
Note turnNote(const Turn& turn, const std::string& name, const std::string& first) {
  const double degrees = turn.angle * 180 / M_PI;
  char text[96];
  if (degrees == 0 && turn.overlap != 0) {
    std::snprintf(text, sizeof text, "keeps its directions, overlap %.2f before warping", turn.overlap);
    return {"frame.kept", Severity::kNote, name, text};
  }
  std::snprintf(text, sizeof text, "turned by %.1f degrees against '", degrees);
  std::string sentence = text + first + "', ";
  if (turn.overlap == 0) return {"frame.turned", Severity::kNote, name, sentence + "as features tell"};
  std::snprintf(text, sizeof text, "overlap %.2f before warping", turn.overlap);
  return {"frame.turned", Severity::kNote, name, sentence + text};
}

/// Every object turned against the first, about straight spines.
Frames straightFrames(const Fields& fields, const std::vector<std::string>& names,
                      const MorphOptions& options, const Progress& progress) {
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
    notes.push_back(turnNote(turn, names[k], names[0]));
  }
  Frames frames = frameObjects(fields, rotations, options);
  frames.notes.insert(frames.notes.begin(), notes.begin(), notes.end());
  return frames;
}

/// The best frames so far, and what they reach.
struct FrameTrials {
  Frames best;
  Agreement reached;
};

/// After one more trial, named `name`. `wanted`: taken whatever it reaches.
FrameTrials afterTrial(FrameTrials trials, const Frames& frames, const Fields& fields,
                       const MorphOptions& options, const char* name, bool wanted) {
  const Agreement a = quickAgreement(fields, frames, options), &least = trials.reached;
  const double gain = 0.5 * (a.before + a.after - least.before - least.after) +
                      turnPrice(trials.best, options.up) - turnPrice(frames, options.up);
  const bool wins = wanted || (gain > kPrice && a.after > least.after - kPrice);
  char text[128];
  std::snprintf(text, sizeof text,
                "%s %s: overlap %.3f before and %.3f after a quick matching, else %.3f and %.3f", name,
                wins ? "taken" : "not taken", a.before, a.after, least.before, least.after);
  if (wins) trials = {frames, a};
  trials.best.notes.push_back({"frame.trial", Severity::kDetail, "", text});
  return trials;
}

/// No overlap is above 1 and no price below 0: what cannot win is not tried.
bool mayBeBeaten(const FrameTrials& trials, const Vec3d& up) {
  return 0.5 * (2 - trials.reached.before - trials.reached.after) + turnPrice(trials.best, up) > kPrice;
}

}  // namespace

Frames chooseFrames(const Fields& fields, const std::vector<std::string>& names, const MorphOptions& options,
                    const Progress& progress) {
  MorphOptions quick = options;
  quick.slices = kQuickSlices;
  FrameTrials trials{straightFrames(fields, names, quick, progress), {}};
  if (options.align == Align::kNone) return trials.best;
  trials.reached = quickAgreement(fields, trials.best, quick);
  const auto consider = [&](const std::optional<Frames>& frames, const char* name, bool wanted) {
    if (progress.cancelled()) throw Cancelled();
    if (frames) trials = afterTrial(std::move(trials), *frames, fields, quick, name, wanted);
  };
  if (mayBeBeaten(trials, options.up)) consider(twistedFrames(fields, names, trials.best), "twist", false);
  const bool wanted = options.spine == SpineKind::kCurved;
  const bool straight = options.spine == SpineKind::kStraight || options.axis.length() > 0;
  if (!wanted && (straight || !mayBeBeaten(trials, options.up))) return trials.best;
  if (const std::optional<LaidFrames> own = framesAlongSpines(fields, names)) {
    if (own->bowed || wanted) consider(own->steady, "curved spine", wanted);
    consider(own->twisted, own->bowed ? "curved spine with twist" : "own spine with twist", false);
  } else if (wanted) {
    trials.best.notes.push_back({"frame.no-curved-spine", Severity::kWarning, "",
                                 "not every shape has a sound curved spine: straight ones are used"});
  }
  return trials.best;
}

}  // namespace slicemorph
