#include "engine/match/choose_frames.h"

#include "engine/frame/feature_turns.h"
#include "engine/frame/inner_samples.h"
#include "engine/frame/settle_turns.h"
#include "engine/frame/spine_frames.h"
#include "engine/match/agreement.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <optional>
#include <utility>

namespace slicemorph {

namespace {

/// Slices for trials: fewer than the default, as they only rank the candidates.
constexpr int kQuickSlices = 32;
/// Gain in overlap that curved spines or a twist must reach: the 3 % that the method's
/// prototype asked of a twist.
constexpr double kPrice = 0.03;
/// Price of strain, in overlap: even a head can be matched with a tail, but only by deforming it. Chosen by
/// hand; guarded by the tests `Facing` in tests/engine/pairs_test.cpp.
constexpr double kStrainPrice = 0.5;

/// By how much a turn's misfit to the features may exceed the least possible one. Chosen by hand.
constexpr double kFeatureSlack = 0.3;

struct TurnsToTry {
  std::vector<Turn> turns;
  bool limited = false;  ///< by the features
};

/// The turns worth trying from one object to another: those that the shapes suggest and that fit the
/// features; if none is left, the turns that the features suggest.
TurnsToTry turnsToTry(const Fields& pair, const std::vector<Vec3d>& from, const std::vector<Vec3d>& to,
                      const Vec3d& up) {
  std::vector<Turn> turns = proposeTurns(*pair[0], *pair[1], up);
  const std::vector<Mat3d> prescribed = turnsOf(from, to);
  if (prescribed.empty()) return {std::move(turns)};
  double best = misfit(from, to, prescribed[0]);
  for (const Mat3d& rotation : prescribed) best = std::min(best, misfit(from, to, rotation));
  turns.erase(
      std::remove_if(turns.begin(), turns.end(),
                     [&](const Turn& t) { return misfit(from, to, t.rotation) > best + kFeatureSlack; }),
      turns.end());
  if (turns.empty())
    for (const Mat3d& rotation : prescribed)
      turns.push_back({rotation, rotationVector(rotation).length(), 0});
  return {std::move(turns), true};
}

/// Turns cost this share of their distortion per right angle, so that what looks the same way stays so.
constexpr double kAngleShare = 0.04;
/// What the distortion of a turn that does not keep `up` must come down to, against the best that does; and where it
/// shows that shapes are alike. Hands that lie anyhow are at .44 to .49 (at 48 to 160 voxels), a rabbit and an armadillo,
/// which both stand, at .57 to .60, a shark and a cow at .66 to .67 without being alike.
constexpr double kLeavesUpright = 0.52, kLeavesUprightAlike = 0.55;
/// Least cosine between the up direction before and after a turn that keeps it.
constexpr double kUprightCosine = 0.98;

bool isUpright(const Mat3d& rotation, const Vec3d& up) {
  return up.length() > 0 && (rotation * up).dot(up) > kUprightCosine * up.lengthSqr();
}

/// One of several turns, and what a quick matching after it reached where one was tried.
struct AgreedTurn {
  size_t index;
  std::optional<Agreement> reached;
};

/// Of turns between which inner distances do not decide, the one after which a quick, coarse matching overlaps
/// best, less the prices of strain and of turning.
AgreedTurn bestByAgreement(const Fields& pair, const std::vector<Turn>& turns,
                           const std::vector<size_t>& among, const MorphOptions& options,
                           const Progress& progress) {
  AgreedTurn best{among[0], std::nullopt};
  double most = -1e30;
  for (size_t i : among) {
    if (among.size() == 1) break;
    if (progress.cancelled()) throw Cancelled();
    const double price = priceOf(turns[i].rotation, options.up);
    if (1 - price <= most) continue;  // no overlap is above 1
    const Frames frames = frameObjects(pair, {Mat3d::identity(), turns[i].rotation}, options);
    const Agreement reached = quickAgreement(pair, frames, options);
    const double value = reached.after - kStrainPrice * reached.strain - price;
    if (value > most) most = value, best = {i, reached};
  }
  return best;
}

/// Those turns that overlap or the up direction suggest; all where there are none of these.
std::vector<size_t> likelyOf(const std::vector<Turn>& turns, const std::vector<size_t>& among) {
  std::vector<size_t> likely;
  for (size_t i : among)
    if (turns[i].likely) likely.push_back(i);
  return likely.empty() ? among : likely;
}

/// Upright turns whose distortion is within this share of the least one are told apart by quick matchings: a rabbit fits
/// an armadillo at 0 and at 90 degrees to 8 %, a cow and a horse the right way round by 11 to 29 %.
constexpr double kUndecided = 0.1;
/// Where another way round fits worse by less than this share, a warning says so.
constexpr double kUnsure = 0.07;
/// From this distortion on shapes are too different for it to tell which way round: a cow and a horse are at .16 the
/// right way round, turned about the up direction; of turns about any axis there are more to be mistaken for each
/// other: two hands are at .06, a blade and a creature at .13 in several ways.
constexpr double kNothingAlike = 0.21, kNothingAlikeFreely = 0.12;
constexpr size_t kMostUndecided = 4;

bool leavesUpright(double freely, double upright) {
  return freely < (freely < kNothingAlikeFreely ? kLeavesUprightAlike : kLeavesUpright) * upright;
}

/// Turns farther from the chosen one than this, radians, are another way round.
constexpr double kOtherWay = M_PI / 3;
/// Shapes look the same when turned if that distorts each one's own inner distances by less than this share of what the
/// other way round distorts those of the pair.
constexpr double kLooksTheSame = 0.5;

/// Below this share of the best upright turn's distortion a free one is told of; see kLeavesUprightAlike.
constexpr double kFreelyBetter = 0.65;

struct ChosenTurn {
  Turn turn;
  TurnChoice choice;
  bool alike = false;  ///< the objects are alike enough for a right way round
  double freely = 1;   ///< distortion of the best turn that leaves upright over that of the best upright one
  std::optional<Agreement> reached = std::nullopt;  ///< by a quick matching after it, where one was tried
};

/// A turn beside which no other was measured.
ChosenTurn unmeasured(const Turn& turn) { return {turn, {turn.angle * 180 / M_PI, -1, -1}}; }

/// How sure a turn is. `rivals`: the turns that might have been chosen instead, those that distort less first.
TurnChoice choiceOf(const InnerSamples (&samples)[2], const std::vector<Turn>& rivals, const Turn& chosen) {
  TurnChoice choice{chosen.angle * 180 / M_PI, innerDistortion(samples[0], samples[1], chosen.rotation), -1};
  const auto next = std::find_if(rivals.begin(), rivals.end(), [&](const Turn& t) {
    return rotationVector(chosen.rotation.transpose() * t.rotation).length() > kOtherWay;
  });
  if (next == rivals.end() || !(choice.distortion > 0)) return choice;
  const double there = innerDistortion(samples[0], samples[1], next->rotation);
  const Mat3d between = chosen.rotation.transpose() * next->rotation;
  const Mat3d ofSecond = next->rotation * chosen.rotation.transpose();
  const double turnedThemselves = std::max(innerDistortion(samples[0], samples[0], between),
                                           innerDistortion(samples[1], samples[1], ofSecond));
  if (turnedThemselves < kLooksTheSame * there) return choice;
  choice.margin = std::max(there / choice.distortion - 1, 0.0);
  return choice;
}

/// The turn where no direction is to be kept: the one that distorts least, but where it is not surely better than none the
/// files' directions, in which scans, for one, often agree. `turns`: those that distort less first, by the samples
/// `few`.
ChosenTurn chooseFreely(const Fields& pair, const std::vector<SettledTurn>& turns,
                        const InnerSamples (&few)[2], const Progress& progress) {
  InnerSamples many[2];
  tbb::parallel_for(0, 2, [&](int k) { many[k] = innerSamples(*pair[size_t(k)], kManyInner); });
  if (progress.cancelled()) throw Cancelled();
  const std::vector<SettledTurn> settled = settleTurns(few, many, turns);
  std::vector<Turn> rivals;
  for (const std::vector<SettledTurn>* others : {&settled, &turns})
    for (const SettledTurn& other : *others) rivals.push_back(other.turn);
  Turn best = settled[0].turn;
  const auto none =
      std::find_if(turns.begin(), turns.end(), [](const SettledTurn& t) { return t.turn.angle == 0; });
  if (none != turns.end() &&
      innerDistortion(many[0], many[1], none->turn.rotation) < (1 + kUnsure) * settled[0].distortion)
    best = none->turn;
  const TurnChoice choice = choiceOf(many, rivals, best);
  return {best, choice, choice.distortion < kNothingAlikeFreely};
}

/// The turn from the first object of a pair to the second whose soft matching distorts inner distances least; of shapes
/// with no inside the first of `turns`. Those that a user's features limit are taken as they are.
ChosenTurn chooseTurn(const Fields& pair, const TurnsToTry& toTry, const MorphOptions& options,
                      const Progress& progress) {
  const std::vector<Turn>& turns = toTry.turns;
  if (turns.size() == 1) return unmeasured(turns[0]);
  const bool standing = options.up.length() > 0;
  InnerSamples samples[2];
  tbb::parallel_for(0, 2, [&](int k) { samples[k] = innerSamples(*pair[size_t(k)]); });
  if (progress.cancelled()) throw Cancelled();
  std::vector<SettledTurn> measured(turns.size());
  std::vector<double> distortion(turns.size());  // with what turning costs
  tbb::parallel_for(size_t(0), turns.size(), [&](size_t i) {
    measured[i] = {turns[i], innerDistortion(samples[0], samples[1], turns[i].rotation)};
    distortion[i] = measured[i].distortion * (1 + (standing ? kAngleShare * turns[i].angle / (M_PI / 2) : 0));
  });
  std::vector<size_t> upright, other;
  for (size_t i = 0; i < turns.size(); ++i)
    if (std::isfinite(distortion[i]))
      (isUpright(turns[i].rotation, options.up) ? upright : other).push_back(i);
  const auto less = [&](size_t i, size_t j) { return distortion[i] < distortion[j]; };
  std::stable_sort(upright.begin(), upright.end(), less);
  std::stable_sort(other.begin(), other.end(), less);
  if (upright.empty() && other.empty()) return unmeasured(turns[0]);
  const bool leaves =
      upright.empty() || (!other.empty() && leavesUpright(distortion[other[0]], distortion[upright[0]]));
  std::vector<size_t> among = leaves ? other : upright;
  const double least = distortion[among[0]];
  if (leaves && !toTry.limited && (!standing || least <= kNothingAlikeFreely)) {
    std::vector<SettledTurn> starts;
    for (size_t i : among) starts.push_back(measured[i]);
    return chooseFreely(pair, starts, samples, progress);
  }
  std::vector<Turn> rivals;
  for (size_t i : among) rivals.push_back(turns[i]);
  if (least > kNothingAlike || leaves) {
    among = likelyOf(turns, among);
  } else {
    const double most = (1 + kUndecided) * least;
    size_t count = 1;
    while (count < std::min(among.size(), kMostUndecided) && distortion[among[count]] <= most) ++count;
    among.resize(count);
  }
  const AgreedTurn agreed = bestByAgreement(pair, turns, among, options, progress);
  const Turn& best = turns[agreed.index];
  const TurnChoice choice = choiceOf(samples, rivals, best);
  return {best, choice, choice.distortion < (leaves ? kNothingAlikeFreely : kNothingAlike),
          leaves || other.empty() ? 1 : distortion[other[0]] / distortion[upright[0]], agreed.reached};
}

/// Mean price of the objects' turns relative to the first.
double turnPrice(const Frames& frames, const Vec3d& up) {
  if (!(up.length() > 0)) return 0;  // how objects lie means nothing
  double price = 0;
  for (size_t k = 1; k < frames.charts.size(); ++k)
    price += priceOf(frames.charts[k].axes * frames.charts[0].axes.transpose(), up);
  return price / double(std::max<size_t>(frames.charts.size() - 1, 1));
}

/// The note on an object's turn relative to the first object, `first`.
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

/// Warnings where objects are alike, so that there is a right way round, and another one fits hardly worse or, not being
/// upright, better.
Notes doubtsOf(const ChosenTurn& chosen, const std::string& name) {
  const TurnChoice& choice = chosen.choice;
  if (chosen.freely < kFreelyBetter)
    return {{"frame.upright-kept", Severity::kWarning, name,
             "stays upright, though turned freely it would fit better; where it lies anyhow, --upright none "
             "turns it so"}};
  if (choice.margin < 0 || choice.margin > kUnsure || !chosen.alike) return {};
  char text[256];
  std::snprintf(text, sizeof text,
                "may be the wrong way round: another way fits hardly worse (%.0f %%); where it is, "
                "--landmarks say what "
                "belongs together, and --align none keeps its directions",
                100 * choice.margin);
  return {{"frame.unsure", Severity::kWarning, name, text}};
}

/// The best frames so far, and their agreement where it is known.
struct FrameTrials {
  Frames best;
  std::optional<Agreement> reached;
};

/// Frames with straight spines, every object turned relative to the first.
FrameTrials straightFrames(const Fields& fields, const std::vector<std::string>& names,
                           const MorphOptions& options, const Progress& progress) {
  std::vector<Mat3d> rotations(fields.size(), Mat3d::identity());
  Notes notes;
  std::vector<TurnChoice> choices;
  std::optional<Agreement> reached;
  for (size_t k = 1; k < fields.size() && options.align == Align::kAuto; ++k) {
    // The features refer to all objects, but only two are compared here.
    MorphOptions pairOptions = options;
    pairOptions.features.clear();
    const Fields pair{fields[0], fields[k]};
    const TurnsToTry turns =
        turnsToTry(pair, pointsOn(options.features, 0), pointsOn(options.features, k), options.up);
    const ChosenTurn chosen = chooseTurn(pair, turns, pairOptions, progress);
    rotations[k] = chosen.turn.rotation;
    choices.push_back(chosen.choice);
    // The same frames and options were tried then.
    if (fields.size() == 2 && options.features.empty()) reached = chosen.reached;
    notes.push_back(turnNote(chosen.turn, names[k], names[0]));
    for (const Note& doubt : doubtsOf(chosen, names[k])) notes.push_back(doubt);
  }
  Frames frames = frameObjects(fields, rotations, options);
  frames.choices = std::move(choices);
  frames.notes.insert(frames.notes.begin(), notes.begin(), notes.end());
  return {std::move(frames), reached};
}

/// The trials after one more, called `name` in its note. `wanted`: the frames are taken
/// regardless of overlap.
FrameTrials afterTrial(FrameTrials trials, const Frames& frames, const Fields& fields,
                       const MorphOptions& options, const char* name, bool wanted) {
  const Agreement a = quickAgreement(fields, frames, options), &least = *trials.reached;
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

/// Frames that keep all directions: those of the world, or, where that gains more overlap than its price, of objects
/// that move and grow towards each other.
Frames framesInOneWorld(const Fields& fields, const MorphOptions& options) {
  const std::vector<Mat3d> none(fields.size(), Mat3d::identity());
  MorphOptions still = options;
  still.align = Align::kNone;
  Frames world = frameObjects(fields, none, still), moved = frameObjects(fields, none, options);
  const double staying = quickAgreement(fields, world, options).after,
               moving = quickAgreement(fields, moved, options).after;
  char text[96];
  std::snprintf(text, sizeof text, "overlap %.3f where they are, %.3f moved, after a quick matching", staying,
                moving);
  Frames& best = moving > staying + kPrice ? moved : world;
  best.notes.push_back({"frame.trial", Severity::kDetail, "", text});
  return best;
}

/// Whether a trial can still win, as no overlap is above 1 and no price below 0.
bool mayBeBeaten(const FrameTrials& trials, const Vec3d& up) {
  return 0.5 * (2 - trials.reached->before - trials.reached->after) + turnPrice(trials.best, up) > kPrice;
}

}  // namespace

Frames chooseFrames(const Fields& fields, const std::vector<std::string>& names, const MorphOptions& options,
                    const Progress& progress) {
  MorphOptions quick = options;
  quick.slices = kQuickSlices;
  if (options.align == Align::kDirections) return framesInOneWorld(fields, quick);
  FrameTrials trials = straightFrames(fields, names, quick, progress);
  const std::vector<TurnChoice> choices = trials.best.choices;
  if (options.align == Align::kNone) return trials.best;
  if (!trials.reached) trials.reached = quickAgreement(fields, trials.best, quick);
  const auto consider = [&](const std::optional<Frames>& frames, const char* name, bool wanted) {
    if (progress.cancelled()) throw Cancelled();
    if (frames) trials = afterTrial(std::move(trials), *frames, fields, quick, name, wanted);
    trials.best.choices = choices;
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
