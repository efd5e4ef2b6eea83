#include "engine/match/follow_limbs.h"

#include "engine/match/flow.h"
#include "engine/match/fold_guard.h"
#include "engine/match/map_overlap.h"
#include "engine/match/middle_samples.h"

#include <utility>

namespace slicemorph {

namespace {

// The figures are chosen by hand; tests/engine/pairs_test.cpp counts the limbs of in-betweens. Lengths are
// fractions of MatchObjects::size.

/// Spacing of the lattice on which each step is fitted; and of the resulting map's lattice, which is finer as
/// it must hold the bends that small steps add up to.
constexpr double kFlowSpacing = 0.08, kFlowLattice = 0.04;
/// The same where points lie all over the bodies.
constexpr double kBodySpacing = 0.06, kBodyLattice = 0.03;
/// Surface samples per object, if there are two; those of the body are further from every limb's centre line
/// than kStillReach of its radii plus kStillGap, so that points near thin limbs do not hold them.
constexpr int kStillSamples = 900;
constexpr double kStillReach = 1.5;
constexpr double kStillGap = 0.03;

bool isAway(const Vec3d& z, const std::vector<PlacedLimb>& limbs, double gap) {
  for (const PlacedLimb& limb : limbs)
    for (size_t n = 0; n < limb.chart.size(); ++n)
      if (!((limb.chart[n] - z).length() > kStillReach * limb.radius[n] + gap)) return false;
  return true;
}

/// `spacing`, `lattice`: see kFlowSpacing and kFlowLattice.
Matching followed(const MatchObjects& objects, Matching matching, std::vector<Correspondence> points,
                  const std::vector<Vec3d>& still, double spacing, double lattice, const Ways& ways = {}) {
  matching.map = flowed(matching.map, points, still, spacing * objects.size, objects.lattice(lattice), ways);
  removeFolds(matching.map);
  matching.overlap = mapOverlap(objects, matching.map);
  matching.base = matching.map;
  matching.limbPoints = std::move(points);
  matching.guesses.clear();
  for (const VectorField& field : matching.map.of) matching.guesses.emplace_back(matching.map.lattice, field);
  return matching;
}

}  // namespace

std::vector<Vec3d> stillPoints(const MatchObjects& objects, const Matching& matching,
                               const std::vector<std::vector<PlacedLimb>>& limbs) {
  std::vector<Vec3d> still;
  const std::vector<MiddleSamples> samples = middleSamples(objects, matching, kStillSamples);
  for (size_t k = 0; k < objects.count(); ++k)
    for (size_t i = 0; i < samples[k].own.size(); ++i)
      if (isAway(samples[k].own[i], limbs[k], kStillGap * objects.size))
        still.push_back(samples[k].points.position[i]);
  return still;
}

Matching followLimbs(const MatchObjects& objects, Matching matching, std::vector<Correspondence> points,
                     const std::vector<Vec3d>& still) {
  return followed(objects, std::move(matching), std::move(points), still, kFlowSpacing, kFlowLattice);
}

Matching followBody(const MatchObjects& objects, Matching matching, std::vector<Correspondence> points,
                    const Ways& ways) {
  return followed(objects, std::move(matching), std::move(points), {}, kBodySpacing, kBodyLattice, ways);
}

}  // namespace slicemorph
