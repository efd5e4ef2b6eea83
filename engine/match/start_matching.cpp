#include "engine/match/start_matching.h"

#include "engine/match/fit_map.h"
#include "engine/match/fold_guard.h"
#include "engine/match/follow_limbs.h"
#include "engine/match/map_overlap.h"
#include "engine/match/take_map.h"

#include <algorithm>
#include <cstdio>
#include <utility>

namespace slicemorph {

namespace {

// The figures are chosen by hand. Lattice spacings are fractions of MatchObjects::size.

/// Spacing of the base warp's lattice.
constexpr double kBaseSpacing = 0.08;
/// The fit of contour pairs is coarse: they determine the map roughly, not in detail.
constexpr MapFit kPairFit{0.12, 4};
/// Every fourth of a contour's samples is used, but no fewer than kLeastSamples.
constexpr int kSampleShare = 4, kLeastSamples = 16;
/// The fit of marks: about as smooth as that of the soft matches.
constexpr MapFit kMarkFit{0.15, 0.5};

Displacements noDisplacements(const MatchObjects& objects) {
  const Lattice lattice = objects.lattice(kBaseSpacing);
  return {lattice,
          std::vector<VectorField>(objects.count(), VectorField(lattice.count(), openvdb::Vec3s(0.f)))};
}

MatchingStart startFromContours(const MatchObjects& objects, const TracedObjects& traced, int samples) {
  MatchingStart start;
  start.matching.notes = traced.notes;
  const BaseWarp base = makeBaseWarp(traced.stacks, traced.planes, traced.position);
  const Displacements none = noDisplacements(objects);
  start.overlapBefore = start.matching.overlap = mapOverlap(objects, none);
  start.matching.map = start.matching.base = none;
  Displacements affine = baseDisplacements(base, none.lattice, objects.box);
  removeFolds(affine);
  TakenMap taken = takeAsFarAsBetter(objects, std::move(start.matching), affine, {}, "per-slice affine");
  start.matching = std::move(taken.matching);
  if (taken.share > 0) start.matching.base = start.matching.map;
  start.pairs = matchContours(traced.stacks, base);
  const std::vector<Correspondence> points = pairCorrespondences(
      start.pairs, traced.stacks, base, std::max(kLeastSamples, objects.ofEach(samples / kSampleShare)));
  if (points.empty()) return start;
  const Displacements map = fittedMap(objects, start.matching, points, kPairFit);
  start.matching = takeAsFarAsBetter(objects, std::move(start.matching), map, {}, "contour pairs").matching;
  return start;
}

/// The matching made to meet the user's features, before anything is matched automatically on top of it.
Matching metFeatures(const MatchObjects& objects, Matching matching) {
  if (objects.features.empty()) return matching;
  const FeaturePoints& guides = objects.guides;
  if (!guides.lines.empty()) {
    const std::vector<Vec3d> still = stillPoints(objects, matching, guides.limbs);
    matching = followLimbs(objects, std::move(matching), guides.lines, still);
  }
  if (!guides.marks.empty()) matching.map = fittedMap(objects, matching, matching.limbPoints, kMarkFit);
  matching.overlap = mapOverlap(objects, matching.map);
  char text[96];
  std::snprintf(text, sizeof text, "%zu features: overlap %.3f", objects.features.size(), matching.overlap);
  matching.notes.push_back({"match.features", Severity::kDetail, "", text});
  return matching;
}

}  // namespace

MatchingStart startMatching(const MatchObjects& objects, const TracedObjects& traced, int samples) {
  MatchingStart start = startFromContours(objects, traced, samples);
  start.matching = metFeatures(objects, std::move(start.matching));
  return start;
}

}  // namespace slicemorph
