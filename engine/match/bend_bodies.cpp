#include "engine/match/bend_bodies.h"

#include "engine/match/couple_bodies.h"
#include "engine/match/elastic_fit.h"
#include "engine/match/follow_limbs.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>
#include <utility>

namespace slicemorph {

namespace {

/// Samples of each surface that the bodies are bent by.
constexpr int kSamples = 3000;
/// Limits of a bending: strain, distance left over in sizes, share without a partner. Within `kSure` the objects
/// are one body in two poses beyond doubt: measured on recorded motions, people and quadrupeds strain is .06 to .17
/// and .1 to 1.3 % have no partner; two thin legs that were missed make that 2.4 %, a leg that one of them lacks
/// 6 %. Beyond `kMost` they are not: a cow onto a horse takes .29, a hand the wrong way round .26.
struct Limits {
  double strain, residual, missed;
  bool hold(const ElasticFit& fit) const {
    return !fit.hopeless && fit.strain < strain && fit.residual < residual && fit.missed < missed;
  }
};
constexpr Limits kSure{0.2, 0.01, 0.015}, kMost{0.25, 0.02, 0.2};
/// What a bending is worth in overlap where the share without partner is no more than this part of the strain: points
/// then keep their place along limbs, which overlap does not show. A collapsing horse (strain .22, 8 %) crumples and is
/// matched right; a body that hardly bends and leaves 6 % over (strain .07) lacks a leg.
constexpr double kBentBonus = 0.08, kCrumpled = 0.6;
/// Residual of a body that is still stiff beyond which it will never fit; bodies that do have at most half of it.
constexpr double kHopeless = 0.05;
/// A limit that no fit exceeds: of bodies that are of one kind by their inner distances.
constexpr double kAnyResidual = 1e9;
/// Parts that turn by more on the way from the middle to an object are carried round in several steps.
constexpr double kTurnOfStep = 0.6;

/// Bodies are compact, with nothing that could swing, where no inner path from their deepest point is longer than its depth
/// this many times. Measured at 40 voxels: 1.2 for a ball, 1.9 for a die; 3.8 for an amphora, 4.0 for a cow, 4.1 for a
/// bunny, more for what has slender limbs.
constexpr double kCompact = 2.5;

/// A chart's position, directions and mean size alone: lengths and angles in it are the world's.
Chart rigidPart(const Chart& chart) {
  Chart rigid;
  rigid.center = chart.center, rigid.axes = chart.axes, rigid.scale = Vec3d(chart.meanScale());
  return rigid;
}

struct Body {
  Chart chart;
  BodyGraph graph;
  OrientedPoints surface;
};

Body bodyOf(const DistanceField& field, const Chart& chart) {
  Body body{rigidPart(chart), {}, {}};
  body.graph = bodyGraph(field, body.chart);
  const ChartSamples samples = chartSamples(field, body.chart);
  openvdb::BBoxd box;
  for (const Vec3d& p : samples.points.position) box.expand(p);
  body.surface = thinned(samples, kSamples, box.min());
  return body;
}

bool isCompact(const BodyGraph& graph) {
  const std::vector<double> paths = graph.distancesFrom(graph.deepest);
  return *std::max_element(paths.begin(), paths.end()) < kCompact * graph.depth;
}

/// What a bent body tells: which points belong together, and how they get there.
struct BodyPoints {
  std::vector<Correspondence> points;
  Ways ways;
};

/// Where the nodes and the surface samples of a body are in some pose of it.
std::vector<Vec3d> posed(const BodyGraph& graph, const BoundPoints& surface, const ElasticFit& pose) {
  std::vector<Vec3d> at = pose.position;
  const std::vector<Vec3d> samples = carried(graph, surface, pose.position, pose.rotation);
  at.insert(at.end(), samples.begin(), samples.end());
  return at;
}

/// Those of a fit of object `from` to object `to`: of its nodes and its surface.
BodyPoints pointsOf(const MatchObjects& objects, const std::vector<Body>& bodies, const ElasticFit& fit,
                    size_t from, size_t to) {
  const BodyGraph& graph = bodies[from].graph;
  const BoundPoints surface = bindPoints(graph, bodies[from].surface.position);
  const Chart middle = blendCharts(objects.charts, {0.5, 0.5}), rigidMiddle = rigidPart(middle);
  // Of a part of the way, in the middle space.
  const auto middleAt = [&](double t) {
    std::vector<Vec3d> at = posed(graph, surface, partWay(graph, fit, t));
    for (Vec3d& p : at) p = middle.toChart(rigidMiddle.toWorld(p));
    return at;
  };
  std::vector<Vec3d> own = graph.position;
  own.insert(own.end(), surface.own.begin(), surface.own.end());
  const std::vector<Vec3d> half = middleAt(0.5), other = posed(graph, surface, fit);
  BodyPoints result;
  result.points.resize(own.size());
  for (size_t i = 0; i < own.size(); ++i) {
    Correspondence& c = result.points[i];
    c.middle = half[i];
    c.at.resize(2);
    c.at[from] = objects.charts[from].toChart(bodies[from].chart.toWorld(own[i]));
    c.at[to] = objects.charts[to].toChart(bodies[to].chart.toWorld(other[i]));
  }
  const int steps = int(std::ceil(0.5 * largestTurn(graph, fit) / kTurnOfStep));
  if (steps < 2) return result;
  result.ways.resize(2);
  for (int step = 1; step < steps; ++step) {
    const double share = double(step) / steps;
    result.ways[from].push_back(middleAt(0.5 - 0.5 * share));
    result.ways[to].push_back(middleAt(0.5 + 0.5 * share));
  }
  return result;
}

/// The objects with room in the middle space for all points on their way.
MatchObjects withRoom(MatchObjects objects, const BodyPoints& body) {
  for (const Correspondence& c : body.points) objects.box.expand(c.middle);
  for (const auto& way : body.ways)
    for (const std::vector<Vec3d>& points : way)
      for (const Vec3d& p : points) objects.box.expand(p);
  return objects;
}

/// Less is better; only what is compared counts.
double badness(const ElasticFit& fit) {
  if (fit.hopeless) return std::numeric_limits<double>::max();
  return fit.strain / kMost.strain + fit.residual / kMost.residual + fit.missed / kMost.missed;
}

/// A fit of object `from` to the other one.
struct DirectedFit {
  ElasticFit fit;
  size_t from;
};

/// Of the fits of either body to the other the better one. `start(k)`: pose of body k on the other.
template <typename Start>
DirectedFit bestFit(const std::vector<Body>& bodies, const Start& start, double hopeless) {
  ElasticFit fits[2];
  tbb::parallel_for(size_t(0), size_t(2), [&](size_t k) {
    fits[k] = fitElastically(bodies[k].graph, bodies[k].surface, bodies[1 - k].surface, start(k), hopeless);
  });
  const size_t from = badness(fits[1]) < badness(fits[0]) ? 1 : 0;
  return {std::move(fits[from]), from};
}

/// Where the map of a matching that followed limbs carries the nodes of body k, in the coordinates of the other one.
std::vector<Vec3d> nodesByLimbs(const MatchObjects& objects, const std::vector<Body>& bodies,
                                const Matching& matching, size_t k) {
  std::vector<Vec3d> carriedTo;
  const MiddleGuess& guess = matching.guesses[k];
  for (const Vec3d& p : bodies[k].graph.position) {
    const Vec3d own = objects.charts[k].toChart(bodies[k].chart.toWorld(p));
    Vec3d s = guess.near(own);
    if (!toMiddle(matching.map, k, own, s)) s = guess.near(own);
    const Vec3d other = s + matching.map.at(1 - k, s);
    carriedTo.push_back(bodies[1 - k].chart.toChart(objects.charts[1 - k].toWorld(other)));
  }
  return carriedTo;
}

/// The best fit of several starts, and the coupling that was one of them; infinitely distorted where none was needed.
struct BestOfStarts {
  DirectedFit best;
  BodyCoupling coupling;
};

/// The best fit of those started from the bodies' own positions, from their coupling by inner distances and from limbs:
/// each only where those before leave doubt.
BestOfStarts bestOfStarts(const MatchObjects& objects, const std::vector<Body>& bodies,
                          const std::function<const std::vector<Matching>&()>& limbCandidates) {
  DirectedFit best = bestFit(
      bodies,
      [&](size_t k) {
        return BodyPose{bodies[k].graph.position, {}};
      },
      kHopeless);
  const auto consider = [&](DirectedFit other) {
    if (badness(other.fit) < badness(best.fit)) best = std::move(other);
  };
  if (kSure.hold(best.fit)) return {std::move(best), {}};
  BodyCoupling coupling = coupleBodies(bodies[0].graph, bodies[1].graph);
  if (coupling.distortion < kOneKind)
    consider(bestFit(
        bodies, [&](size_t k) { return coupling.pose[k]; }, kAnyResidual));
  if (best.fit.hopeless) return {std::move(best), std::move(coupling)};
  for (const Matching& start : limbCandidates()) {
    if (kSure.hold(best.fit)) break;
    if (start.limbPoints.empty()) continue;
    const auto byLimbs = [&](size_t k) { return BodyPose{nodesByLimbs(objects, bodies, start, k), {}}; };
    consider(bestFit(bodies, byLimbs, kHopeless));
  }
  return {std::move(best), std::move(coupling)};
}

/// The matching that carries coupled points onto each other: of one kind of body in other proportions, as an armadillo
/// and a man, the hands then meet, which bending without stretching cannot bring together.
Bending coupled(const MatchObjects& objects, const std::vector<Body>& bodies, const Matching& matching,
                const BodyCoupling& coupling) {
  BodyPoints body;
  for (const auto& pair : coupling.partners) {
    Correspondence c;
    for (size_t k = 0; k < 2; ++k)
      c.at.push_back(objects.charts[k].toChart(bodies[k].chart.toWorld(pair[k])));
    c.middle = 0.5 * (c.at[0] + c.at[1]);
    body.points.push_back(c);
  }
  Bending bending{false, withRoom(objects, body), {}, false};
  bending.matching = followLimbs(bending.objects, matching, std::move(body.points), {});
  // As of bent bodies: without it a woman's hands miss an armadillo's by a third of its size, for .003 of overlap.
  bending.matching.bonus = kBentBonus;
  char text[160];
  std::snprintf(text, sizeof text, "coupled by inner distances: distortion %.3f; overlap %.3f",
                coupling.distortion, bending.matching.overlap);
  bending.matching.notes.push_back({"match.coupled", Severity::kDetail, "", text});
  return bending;
}

}  // namespace

std::optional<Bending> bentOntoEachOther(
    const MatchObjects& objects, const Matching& matching,
    const std::function<const std::vector<Matching>&()>& limbCandidates) {
  if (objects.count() != 2 || !objects.features.empty() || matching.overlap > kLieOnEachOther)
    return std::nullopt;
  // Charts along curved spines bend the objects already.
  for (const Chart& chart : objects.charts)
    if (!chart.bend.straight()) return std::nullopt;
  std::vector<Body> bodies(2);
  tbb::parallel_for(size_t(0), size_t(2),
                    [&](size_t k) { bodies[k] = bodyOf(*objects.shape.fields[k], objects.charts[k]); });
  for (const Body& body : bodies)
    if (body.graph.position.empty()) return std::nullopt;
  if (isCompact(bodies[0].graph) && isCompact(bodies[1].graph)) return std::nullopt;
  const auto [best, coupling] = bestOfStarts(objects, bodies, limbCandidates);
  const ElasticFit& fit = best.fit;
  if (!kMost.hold(fit)) {
    if (!(coupling.distortion < kOneKind)) return std::nullopt;
    return coupled(objects, bodies, matching, coupling);
  }
  BodyPoints body = pointsOf(objects, bodies, fit, best.from, 1 - best.from);
  Bending bending{true, withRoom(objects, body), {}, kSure.hold(fit)};
  bending.matching = followBody(bending.objects, matching, std::move(body.points), body.ways);
  bending.matching.swings = true;
  bending.matching.bonus = fit.missed < kCrumpled * fit.strain ? kBentBonus : 0;
  char text[160];
  std::snprintf(
      text, sizeof text,
      "bent onto each other: strain %.3f, left over %.4f of the size, %.1f %% without partner; overlap %.3f",
      fit.strain, fit.residual, 100 * fit.missed, bending.matching.overlap);
  bending.matching.notes.push_back({"match.bent", Severity::kDetail, "", text});
  return bending;
}

}  // namespace slicemorph
