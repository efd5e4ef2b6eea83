#include "engine/match/limb_candidates.h"

#include "engine/match/follow_limbs.h"
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

/// The points of the limbs that may be followed.
struct LimbPoints {
  std::vector<Correspondence> matched;  ///< of limbs that all objects have
  std::vector<Correspondence> all;      ///< of these, and of limbs that grow out of the body
  int matches = 0, grown = 0;           ///< numbers of limbs of either kind
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
    const std::vector<Correspondence> points = limbPoints(group.limb);
    found.all.insert(found.all.end(), points.begin(), points.end());
    ++(group.grows ? found.grown : found.matches);
    if (!group.grows) found.matched.insert(found.matched.end(), points.begin(), points.end());
  }
  return found;
}

/// Such as "limbs: 2 and 3 found, 2 matched, 1 to grow out of the body".
Note limbNote(const std::vector<std::vector<PlacedLimb>>& limbs, const LimbPoints& points) {
  std::string counts;
  for (const auto& list : limbs) counts += (counts.empty() ? "" : " and ") + std::to_string(list.size());
  return {"match.limbs", Severity::kDetail, "",
          "limbs: " + counts + " found, " + std::to_string(points.matches) + " matched, " +
              std::to_string(points.grown) + " to grow out of the body"};
}

/// The candidates so far, while the sets of limbs to follow are tried one after the other.
struct Trials {
  std::vector<Matching> candidates;
  double without = 0;  ///< overlap after a quick matching that follows no limbs
  double most = 0;     ///< value that the next trial must exceed to become the only candidate
  Notes notes;
};

Trials withTrial(const MatchObjects& objects, Trials trials, Matching followed, double bonus,
                 const char* name) {
  followed.bonus = bonus;
  const Matching after = triedQuickly(objects, followed);
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

}  // namespace

std::vector<Matching> limbCandidates(const MatchObjects& objects, const Matching& matching) {
  const FeaturePoints& guides = objects.guides;
  std::vector<std::vector<PlacedLimb>> limbs =
      placedLimbs(objects.shape.fields, objects.charts, matching.map);
  LimbPoints points = limbPointsOf(
      groupLimbs(limbs, objects.shape.fields, objects.charts, matching.map, objects.size), guides);
  Matching start = matching;
  start.notes.push_back(limbNote(limbs, points));
  if (points.all.empty()) return {start};
  for (auto* list : {&points.matched, &points.all})
    list->insert(list->end(), guides.lines.begin(), guides.lines.end());
  const double without = triedQuickly(objects, start).overlap;
  const double met = points.matches > 0 ? kMatchedBonus : 0;
  if (1 + met + (points.grown > 0 ? kGrownBonus : 0) <= without + kWorthTrying)
    return {start};  // none is above 1
  for (size_t k = 0; k < objects.count(); ++k)
    limbs[k].insert(limbs[k].end(), guides.limbs[k].begin(), guides.limbs[k].end());
  const std::vector<Vec3d> still = stillPoints(objects, start, limbs);
  Trials trials{{start}, without, without + kNoDoubt, {}};
  if (points.matches > 0)
    trials = withTrial(objects, std::move(trials), followLimbs(objects, start, points.matched, still), met,
                       "matched limbs followed");
  if (points.grown > 0)
    trials = withTrial(objects, std::move(trials), followLimbs(objects, start, points.all, still),
                       met + kGrownBonus, "all limbs followed");
  for (Matching& candidate : trials.candidates)
    candidate.notes.insert(candidate.notes.end(), trials.notes.begin(), trials.notes.end());
  return trials.candidates;
}

}  // namespace slicemorph
