#include "engine/match/limb_candidates.h"

#include "engine/match/follow_limbs.h"
#include "engine/match/map_overlap.h"
#include "engine/match/refine.h"
#include "engine/match/take_map.h"

#include <cstdio>
#include <string>
#include <utility>

namespace slicemorph {

namespace {

// In overlap, chosen by hand; Limbs.ALegGrowsOutOfTheBody and tests/engine/pairs_test.cpp
// guard what they are for.

/// Bonus for limbs that grow out of the body: it costs overlap, as the air beside such a limb has no
/// counterpart on the object that lacks it.
constexpr double kGrownBonus = 0.03;
/// Bonus for limbs that meet their partners: where both ways overlap about as well, feet that meet feet are right. A cow's
/// forelegs were a galloping horse's belly for .006 of overlap.
constexpr double kMatchedBonus = 0.03;
/// Gain after a quick matching that surely remains after the whole matching; and gain from which the whole
/// matching is worth trying.
constexpr double kNoDoubt = 0.1, kWorthTrying = 0.04;
/// A limb that grows does harm if the objects overlap by this much less around it, up to kAround (of their size) from
/// its centre line, than where it does not. On four pairs of models the one limb whose absence
/// mattered lost .5, 18 others at most .3.
constexpr double kHarm = 0.35, kAround = 0.1;

using Points = std::vector<Correspondence>;

/// The points of the limbs that may be followed.
struct LimbPoints {
  Points matched;             ///< of limbs that all objects have
  int matches = 0;            ///< number of these
  std::vector<Points> grown;  ///< of each limb that grows out of the body

  Points all() const {
    Points points = matched;
    for (const Points& limb : grown) points.insert(points.end(), limb.begin(), limb.end());
    return points;
  }
};

/// Whether a user's line feature already prescribes a limb.
bool isPrescribedLimb(const LimbGroup& group, const FeaturePoints& guides) {
  for (size_t k = 0; k < group.limb.size(); ++k)
    if (isPrescribedBy(group.limb[k], guides.limbs[k])) return true;
  return false;
}

LimbPoints limbPointsOf(const std::vector<LimbGroup>& groups, const FeaturePoints& guides) {
  LimbPoints found;
  for (const LimbGroup& group : groups) {
    if (isPrescribedLimb(group, guides)) continue;
    Points points = limbPoints(group.limb);
    if (group.grows) {
      found.grown.push_back(std::move(points));
    } else {
      ++found.matches;
      found.matched.insert(found.matched.end(), points.begin(), points.end());
    }
  }
  return found;
}

/// Such as "limbs: 2 and 3 found, 2 matched, 1 to grow out of the body".
Note limbNote(const std::vector<std::vector<PlacedLimb>>& limbs, const LimbPoints& points) {
  std::string counts;
  for (const auto& list : limbs) counts += (counts.empty() ? "" : " and ") + std::to_string(list.size());
  return {"match.limbs", Severity::kDetail, "",
          "limbs: " + counts + " found, " + std::to_string(points.matches) + " matched, " +
              std::to_string(points.grown.size()) + " to grow out of the body"};
}

/// The candidates so far, while the sets of limbs to follow are tried one after the other.
struct Trials {
  std::vector<Matching> candidates;
  double without = 0;  ///< overlap after a quick matching that follows no limbs
  double most = 0;     ///< value that the next trial must exceed to become the only candidate
  Notes notes;
};

/// `after`: `followed` after a quick matching.
Trials withTrial(Trials trials, Matching followed, const Matching& after, const char* name) {
  char text[128];
  std::snprintf(text, sizeof text, "%s: overlap %.3f after a quick matching, else %.3f", name, after.overlap,
                trials.without);
  trials.notes.push_back({"match.limbs-tried", Severity::kDetail, "", text});
  const bool noneWon = trials.most == trials.without + kNoDoubt;
  if (after.value() > trials.most + kSureGain) {
    trials.most = after.value();
    trials.candidates = {std::move(followed)};
  } else if (noneWon && after.value() > trials.without + kWorthTrying) {
    trials.candidates.push_back(std::move(followed));
  }
  return trials;
}

/// The limbs without those that do harm by growing. `plain`, `grown`: maps where none and where all of them grow.
LimbPoints withoutHarm(const MatchObjects& objects, const LimbPoints& points, const Displacements& plain,
                       const Displacements& grown) {
  std::vector<std::vector<Vec3d>> lines;
  for (const Points& limb : points.grown) {
    lines.emplace_back();
    for (size_t n = 0; n < limb.size(); n += 1 + kPointsAround) lines.back().push_back(limb[n].middle);
  }
  const std::vector<double> before = overlapsAround(objects, plain, lines, kAround * objects.size),
                            after = overlapsAround(objects, grown, lines, kAround * objects.size);
  LimbPoints kept{points.matched, points.matches, {}};
  for (size_t i = 0; i < lines.size(); ++i)
    if (before[i] - after[i] < kHarm) kept.grown.push_back(points.grown[i]);
  return kept;
}

}  // namespace

std::vector<Matching> limbCandidates(const MatchObjects& objects, const Matching& matching) {
  const FeaturePoints& guides = objects.guides;
  std::vector<std::vector<PlacedLimb>> limbs =
      placedLimbs(objects.shape.fields, objects.charts, matching.map);
  LimbPoints points = limbPointsOf(
      groupLimbs(limbs, objects.shape.fields, objects.charts, matching.map, objects.size), guides);
  Matching start = matching;
  start.notes.push_back(limbNote(limbs, points));
  if (points.matches == 0 && points.grown.empty()) return {start};
  points.matched.insert(points.matched.end(), guides.lines.begin(), guides.lines.end());
  const Matching plain = triedQuickly(objects, start);
  const double without = plain.overlap, met = points.matches > 0 ? kMatchedBonus : 0;
  if (1 + met + (points.grown.empty() ? 0 : kGrownBonus) <= without + kWorthTrying)
    return {start};  // none is above 1
  for (size_t k = 0; k < objects.count(); ++k)
    limbs[k].insert(limbs[k].end(), guides.limbs[k].begin(), guides.limbs[k].end());
  const std::vector<Vec3d> still = stillPoints(objects, start, limbs);
  Trials trials{{start}, without, without + kNoDoubt, {}};
  const auto follow = [&](const Points& of, double bonus) {
    Matching followed = followLimbs(objects, start, of, still);
    followed.bonus = bonus;
    return followed;
  };
  if (points.matches > 0) {
    Matching matched = follow(points.matched, met);
    const Matching after = triedQuickly(objects, matched);
    trials = withTrial(std::move(trials), std::move(matched), after, "matched limbs followed");
  }
  if (!points.grown.empty()) {
    Matching all = follow(points.all(), met + kGrownBonus);
    const Matching after = triedQuickly(objects, all);
    trials = withTrial(std::move(trials), std::move(all), after, "all limbs followed");
    const LimbPoints kept = withoutHarm(objects, points, plain.map, after.map);
    const bool fewer = kept.grown.size() < points.grown.size() && !kept.grown.empty();
    if (fewer && after.value() > without - kNoDoubt) {
      Matching helpful = follow(kept.all(), met + kGrownBonus);
      const Matching quick = triedQuickly(objects, helpful);
      trials = withTrial(std::move(trials), std::move(helpful), quick, "but for those that do harm");
    }
  }
  for (Matching& candidate : trials.candidates)
    candidate.notes.insert(candidate.notes.end(), trials.notes.begin(), trials.notes.end());
  return trials.candidates;
}

}  // namespace slicemorph
