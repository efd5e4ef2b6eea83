#include "engine/match/register.h"

#include "engine/match/bend_bodies.h"
#include "engine/match/finish_map.h"
#include "engine/match/fold_guard.h"
#include "engine/match/limb_candidates.h"
#include "engine/match/map_overlap.h"
#include "engine/match/refine.h"
#include "engine/match/start_matching.h"
#include "engine/match/take_map.h"
#include "slicemorph/errors.h"

#include <cstdio>
#include <utility>

namespace slicemorph {

namespace {

/// Loss of overlap from one frame to the next that is taken for a cut. Chosen by hand; guarded by
/// Sequence.CutsAndNewEqualsArePlannedAnew.
constexpr double kCut = 0.15;

/// A matching that starts from a map that is nearly right.
Matching continuedMatching(const MatchObjects& objects, const Displacements& map, const Displacements& base) {
  Matching matching;
  matching.base = continuedOver(objects, base);
  matching.map = resampled(map, objects.lattice(kFollowRounds[0].spacing));
  removeFolds(matching.map);
  for (const VectorField& field : matching.map.of) matching.guesses.emplace_back(matching.map.lattice, field);
  matching.overlap = mapOverlap(objects, matching.map);
  return matching;
}

/// The matching after kFollowRounds. `done`: share of the whole work to report, 0 to 1.
Matching afterFollowRounds(const MatchObjects& objects, Matching matching, Progress& progress, double done) {
  for (const Round& round : kFollowRounds) {
    if (progress.cancelled()) throw Cancelled();
    progress.report("match", done);
    matching = refined(objects, std::move(matching), round);
  }
  return matching;
}

Registration registrationOf(const MatchObjects& objects, Matching matching, MatchingStart start) {
  Registration result;
  result.map = finishedMap(objects, matching.map);
  result.base = std::move(matching.base);
  result.swings = matching.swings;
  result.pairs = std::move(start.pairs);
  result.overlapBefore = start.overlapBefore;
  result.overlapAfter = mapOverlap(objects, result.map);
  result.notes = std::move(matching.notes);
  return result;
}

/// Adds warnings of the features that the final map does not meet.
Registration withContradictions(const MatchObjects& objects, Registration made) {
  for (const Note& warning : contradictions(objects.features, objects.charts, made.map, objects.size))
    made.notes.push_back(warning);
  return made;
}

/// A matching that rounds may start from.
struct Candidate {
  const MatchObjects* objects;
  Matching matching;
  Rounds rounds;
};

/// The best candidate after running its rounds on every one; the earlier one unless another is clearly
/// better.
Candidate bestAfterRounds(std::vector<Candidate> candidates, Progress& progress) {
  std::optional<Candidate> best;
  double all = 0;
  int done = 0;
  for (const Candidate& candidate : candidates) all += double(candidate.rounds.size());
  for (Candidate& candidate : candidates) {
    for (const Round& round : candidate.rounds) {
      if (progress.cancelled()) throw Cancelled();
      progress.report("match", 0.2 + 0.8 * done++ / all);
      candidate.matching = refined(*candidate.objects, std::move(candidate.matching), round);
    }
    if (!best || candidate.matching.value() > best->matching.value() + kSureGain) best = std::move(candidate);
  }
  return std::move(*best);
}

}  // namespace

Registration registerObjects(const MatchObjects& objects, const TracedObjects& traced, int samples,
                             const Rounds& rounds, Progress& progress) {
  MatchingStart start = startMatching(objects, traced, samples);
  std::vector<Matching> limbs;
  const auto byLimbs = [&]() -> std::vector<Matching>& {
    if (limbs.empty()) limbs = limbCandidates(objects, start.matching);
    return limbs;
  };
  std::vector<Candidate> candidates;
  std::optional<Bending> bent = bentOntoEachOther(objects, start.matching, byLimbs);
  const bool sure = bent && bent->sure;
  if (bent)
    candidates.push_back(
        {&bent->objects, std::move(bent->matching), bent->bent ? roundsAfterBending(rounds) : rounds});
  if (!sure)
    for (Matching& matching : byLimbs()) candidates.push_back({&objects, std::move(matching), rounds});
  Candidate best = bestAfterRounds(std::move(candidates), progress);
  return withContradictions(objects,
                            registrationOf(*best.objects, std::move(best.matching), std::move(start)));
}

Registration startRegistration(const MatchObjects& objects, const TracedObjects& traced, int samples) {
  MatchingStart start = startMatching(objects, traced, samples);
  Matching matching = std::move(start.matching);
  return registrationOf(objects, std::move(matching), std::move(start));
}

Registration refineRegistration(Registration made, const MatchObjects& objects, Progress& progress) {
  Matching matching =
      afterFollowRounds(objects, continuedMatching(objects, made.map, made.map), progress, 0.95);
  Registration result =
      withContradictions(objects, registrationOf(objects, std::move(matching), {{}, {}, made.overlapBefore}));
  made.notes.insert(made.notes.end(), result.notes.begin(), result.notes.end());
  result.notes = std::move(made.notes);
  result.pairs = std::move(made.pairs);
  return result;
}

std::optional<Registration> followRegistration(const Registration& before, const MatchObjects& objects,
                                               Progress& progress) {
  Matching matching = continuedMatching(objects, before.map, before.base);
  const double overlap = matching.overlap;
  if (overlap < before.overlapAfter - kCut) return std::nullopt;
  char text[128];
  std::snprintf(text, sizeof text, "the matching of the frame before: overlap %.3f, there %.3f", overlap,
                before.overlapAfter);
  matching.swings = before.swings;
  matching.notes.push_back({"sequence.continued", Severity::kDetail, "", text});
  matching = afterFollowRounds(objects, std::move(matching), progress, 0.5);
  return withContradictions(objects, registrationOf(objects, std::move(matching), {{}, {}, overlap}));
}

}  // namespace slicemorph
