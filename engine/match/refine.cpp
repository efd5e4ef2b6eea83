#include "engine/match/refine.h"

#include "engine/match/closest_points.h"
#include "engine/match/core_points.h"
#include "engine/match/fit_map.h"
#include "engine/match/middle_samples.h"
#include "engine/match/soft_points.h"
#include "engine/match/take_map.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace slicemorph {

namespace {

/// Least number of samples of an inner surface. Chosen by hand.
constexpr int kLeastInner = 300;
/// Number of points for which a round's stiffness is given; it is scaled with their number, as the data term
/// of the fit grows with it.
constexpr double kPointsOfStiffness = 2000;
/// A round of soft matches overlaps by less than this more than the one before, whose blur is a quarter wider: on eleven
/// pairs by .096 at most.
constexpr double kSoftStep = 0.1;

/// Closest points of the inner surfaces, sampled as densely as the shapes; each on the same inner surface of
/// the other objects.
std::vector<Correspondence> innerSurfacePoints(const MatchObjects& objects, const Matching& matching,
                                               const Round& round) {
  std::vector<Correspondence> points;
  for (const MatchSurface& surface : objects.inner) {
    std::vector<MiddleSamples> samples(objects.count());
    for (size_t k = 0; k < objects.count(); ++k) {
      if (!surface.fields[k]) continue;
      const double share = std::min(surface.samples[k].area / objects.shape.samples[k].area, 1.0);
      const int count = std::max(objects.ofEach(kLeastInner), int(objects.ofEach(round.samples) * share));
      samples[k] = middleSamples(matching, k, thinned(surface.samples[k], count, objects.box.min()));
    }
    const std::vector<Correspondence> found =
        closestPoints(surface.fields, objects.charts, matching.map, samples, round.reach * objects.size);
    points.insert(points.end(), found.begin(), found.end());
  }
  return points;
}

std::vector<Correspondence> roundPoints(const MatchObjects& objects, const Matching& matching,
                                        const Round& round) {
  const std::vector<MiddleSamples> samples = middleSamples(objects, matching, round.samples);
  const double reach = round.reach * objects.size;
  if (round.kind == Round::Kind::kSoft) return softPoints(matching.map, samples, reach);
  std::vector<Correspondence> points =
      closestPoints(objects.shape.fields, objects.charts, matching.map, samples, reach);
  const std::vector<Correspondence> inner = innerSurfacePoints(objects, matching, round);
  points.insert(points.end(), inner.begin(), inner.end());
  if (!matching.swings) return points;
  // Only bodies bent onto each other are so near that a thin part lies on its own like.
  const std::vector<Correspondence> cores = corePoints(objects, matching, reach);
  points.insert(points.end(), cores.begin(), cores.end());
  return points;
}

/// Closest points of two objects nearly always help, in the last rounds by little each: they are only
/// refused where they harm. Of more than two objects they pull each towards whichever other is nearest,
/// and must gain overlap.
GainWanted gainWanted(const MatchObjects& objects, const Round& round) {
  if (round.kind == Round::Kind::kSoft || objects.count() > 2) return {};
  return {-2 * kSureGain, -kSureGain};
}

}  // namespace

Matching refined(const MatchObjects& objects, Matching matching, const Round& round) {
  const bool soft = round.kind == Round::Kind::kSoft;
  if (soft && matching.overlap > kLieOnEachOther) return matching;
  if (soft && matching.softLoss > kSoftStep) {  // it would not be taken
    matching.softLoss -= kSoftStep;
    return matching;
  }
  std::vector<Correspondence> points = roundPoints(objects, matching, round);
  if (points.empty()) return matching;
  points.insert(points.end(), matching.limbPoints.begin(), matching.limbPoints.end());
  char name[64];
  std::snprintf(name, sizeof name, "%s %.3f (%zu points)", soft ? "soft match" : "closest points",
                round.reach, points.size());
  const double density = double(points.size()) / kPointsOfStiffness;
  const Displacements map =
      fittedMap(objects, matching, std::move(points), {round.spacing, round.stiffness * density});
  const double before = matching.overlap;
  TakenMap taken = takeAsFarAsBetter(objects, std::move(matching), map, gainWanted(objects, round), name);
  taken.matching.softLoss = soft ? before - taken.overlap : 0;
  return std::move(taken.matching);
}

Matching triedQuickly(const MatchObjects& objects, Matching matching) {
  for (const Round& round : kQuickRounds) matching = refined(objects, std::move(matching), round);
  return matching;
}

}  // namespace slicemorph
