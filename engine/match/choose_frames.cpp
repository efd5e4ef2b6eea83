#include "engine/match/choose_frames.h"

#include "engine/errors.h"
#include "engine/frame/spine_frames.h"
#include "engine/match/register.h"

#include <algorithm>
#include <cstdio>

namespace slicemorph {

namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr int kQuickSlices = 32;
/// What curved spines or a twist must win: they are for objects that clearly need them.
constexpr double kPrice = 0.03;

/// The turn from the first object to another one.
Turn chooseTurn(const Fields& pair, const MorphOptions& options, Progress& progress) {
  const std::vector<Turn> turns = proposeTurns(*pair[0], *pair[1]);
  if (turns.size() == 1) return turns[0];
  const Turn* best = nullptr;
  double most = -1e30;
  for (const Turn& turn : turns) {
    if (1 - priceOf(turn.angle) <= most) continue;  // no overlap is above 1
    const Frames frames = frameObjects(pair, {Mat3d::identity(), turn.rotation}, options);
    const double value = quickAgreement(pair, frames, options, progress).after - priceOf(turn.angle);
    if (value > most) most = value, best = &turn;
  }
  return *best;
}

/// Price of all the objects' turns against the first.
double turnPrice(const Frames& frames) {
  double price = 0;
  for (size_t k = 1; k < frames.charts.size(); ++k)
    price += priceOf(rotationVector(frames.charts[0].axes.transpose() * frames.charts[k].axes).length());
  return price / double(std::max<size_t>(frames.charts.size() - 1, 1));
}

Frames straightFrames(const Fields& fields, const MorphOptions& options, Progress& progress) {
  std::vector<Mat3d> rotations(fields.size(), Mat3d::identity());
  std::vector<std::string> notes;
  for (size_t k = 1; k < fields.size() && options.align != Align::kNone; ++k) {
    if (const std::optional<Mat3d> told = turnOfLandmarks(options.landmarks, 0, k)) {
      rotations[k] = *told;
      notes.push_back("shape " + std::to_string(k + 1) + " turned as the landmarks tell");
      continue;
    }
    // Only two shapes are looked at here, and the landmarks tell of all.
    MorphOptions pairOptions = options;
    pairOptions.landmarks.clear();
    const Turn turn = chooseTurn({fields[0], fields[k]}, pairOptions, progress);
    rotations[k] = turn.rotation;
    const double degrees = turn.angle * 180 / kPi;
    char text[128];
    if (degrees > 0)
      std::snprintf(text, sizeof text, "shape %zu turned by %.1f degrees against the first, overlap %.2f before warping",
                    k + 1, degrees, turn.overlap);
    else
      std::snprintf(text, sizeof text, "shape %zu keeps its directions, overlap %.2f before warping", k + 1, turn.overlap);
    notes.push_back(text);
  }
  Frames frames = frameObjects(fields, rotations, options);
  frames.notes.insert(frames.notes.begin(), notes.begin(), notes.end());
  return frames;
}

}  // namespace

Frames chooseFrames(const Fields& fields, const MorphOptions& options, Progress& progress) {
  MorphOptions quick = options;
  quick.slices = kQuickSlices;
  Frames best = straightFrames(fields, quick, progress);
  if (options.align == Align::kNone) return best;
  Agreement least = quickAgreement(fields, best, quick, progress);
  // No overlap is above 1 and no price below 0: what cannot win is not tried.
  const auto mayWin = [&] { return 0.5 * (2 - least.before - least.after) + turnPrice(best) > kPrice; };
  const auto consider = [&](const std::optional<Frames>& frames, const char* name, bool wanted = false) {
    if (!frames) return;
    const Agreement a = quickAgreement(fields, *frames, quick, progress);
    const double gain = 0.5 * (a.before + a.after - least.before - least.after) + turnPrice(best) - turnPrice(*frames);
    const bool wins = wanted || (gain > kPrice && a.after > least.after - kPrice);
    char text[128];
    std::snprintf(text, sizeof text, "%s %s: overlap %.3f before and %.3f after a quick matching, else %.3f and %.3f", name,
                  wins ? "taken" : "not taken", a.before, a.after, least.before, least.after);
    if (wins) best = *frames, least = a;
    best.notes.push_back(text);
  };
  if (mayWin()) consider(twistedFrames(fields, best), "twist");
  const bool wanted = options.spine == SpineKind::kCurved;
  if (!wanted && (options.spine == SpineKind::kStraight || options.axis.length() > 0 || !mayWin())) return best;
  if (const std::optional<LaidFrames> own = framesAlongSpines(fields)) {
    if (own->bowed || wanted) consider(own->steady, "curved spine", wanted);
    consider(own->twisted, own->bowed ? "curved spine with twist" : "own spine with twist");
  } else if (wanted) {
    best.notes.push_back("not every shape has a sound curved spine: straight ones are used");
  }
  return best;
}

}  // namespace slicemorph
