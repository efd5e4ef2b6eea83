#include "engine/match/bend_bodies.h"

#include "engine/match/elastic_fit.h"
#include "engine/match/follow_limbs.h"

#include <tbb/parallel_for.h>

#include <cstdio>
#include <limits>
#include <utility>

namespace slicemorph {

namespace {

/// Samples of each surface that the bodies are bent by.
constexpr int kSamples = 3000;
/// Limits of a bending: strain, distance left over in sizes, share without a partner. Within `kSure` the objects
/// are one body in two poses beyond doubt: measured on recorded motions, people and quadrupeds strain is .06 to .17
/// and .1 to 3 % have no partner; a leg that one of them lacks makes that 6 %. Beyond `kMost` they are not: a cow
/// onto a horse takes .29, a hand the wrong way round .26.
struct Limits {
  double strain, residual, missed;
  bool hold(const ElasticFit& fit) const {
    return fit.strain < strain && fit.residual < residual && fit.missed < missed;
  }
};
constexpr Limits kSure{0.2, 0.01, 0.03}, kMost{0.25, 0.02, 0.2};
/// What a bending is worth in overlap where the share without partner is no more than this part of the strain: points
/// then keep their place along limbs, which overlap does not show. A collapsing horse (strain .22, 8 %) crumples and is
/// matched right; a body that hardly bends and leaves 6 % over (strain .07) lacks a leg.
constexpr double kBentBonus = 0.05, kCrumpled = 0.6;
/// Residual of a body that is still stiff beyond which it will never fit; bodies that do have at most half of it.
constexpr double kHopeless = 0.05;
/// Objects that lie on each other so well already are not bent.
constexpr double kNeedsNoBending = 0.96;

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

/// The correspondences that a fit of object `from` to object `to` gives: of its nodes and its surface.
std::vector<Correspondence> pointsOf(const MatchObjects& objects, const std::vector<Body>& bodies,
                                     const ElasticFit& fit, size_t from, size_t to) {
  const BodyGraph& graph = bodies[from].graph;
  const ElasticFit half = halfWay(graph, fit);
  const Chart middle = blendCharts(objects.charts, {0.5, 0.5}), rigidMiddle = rigidPart(middle);
  std::vector<Correspondence> points;
  const auto add = [&](const Vec3d& own, const Vec3d& between, const Vec3d& other) {
    Correspondence c;
    c.middle = middle.toChart(rigidMiddle.toWorld(between));
    c.at.resize(2);
    c.at[from] = objects.charts[from].toChart(bodies[from].chart.toWorld(own));
    c.at[to] = objects.charts[to].toChart(bodies[to].chart.toWorld(other));
    points.push_back(std::move(c));
  };
  for (size_t i = 0; i < graph.position.size(); ++i)
    add(graph.position[i], half.position[i], fit.position[i]);
  const BoundPoints surface = bindPoints(graph, bodies[from].surface.position);
  const std::vector<Vec3d> between = carried(graph, surface, half.position, half.rotation),
                           other = carried(graph, surface, fit.position, fit.rotation);
  for (size_t i = 0; i < between.size(); ++i) add(surface.own[i], between[i], other[i]);
  return points;
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

/// Of the fits of either body to the other the better one. `start(k)`: position per node of body k, on the other.
template <typename Start>
DirectedFit bestFit(const std::vector<Body>& bodies, const Start& start) {
  ElasticFit fits[2];
  tbb::parallel_for(size_t(0), size_t(2), [&](size_t k) {
    fits[k] = fitElastically(bodies[k].graph, bodies[k].surface, bodies[1 - k].surface, start(k), kHopeless);
  });
  const size_t from = badness(fits[1]) < badness(fits[0]) ? 1 : 0;
  return {std::move(fits[from]), from};
}

/// Where the map of a matching that followed limbs carries the nodes of body k, in the coordinates of the other one.
std::vector<Vec3d> carriedNodes(const MatchObjects& objects, const std::vector<Body>& bodies,
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

}  // namespace

std::optional<Bending> bentOntoEachOther(
    const MatchObjects& objects, const Matching& matching,
    const std::function<const std::vector<Matching>&()>& limbCandidates) {
  if (objects.count() != 2 || !objects.features.empty() || matching.overlap > kNeedsNoBending)
    return std::nullopt;
  // Charts along curved spines bend the objects already.
  for (const Chart& chart : objects.charts)
    if (!chart.bend.straight()) return std::nullopt;
  std::vector<Body> bodies(2);
  tbb::parallel_for(size_t(0), size_t(2),
                    [&](size_t k) { bodies[k] = bodyOf(*objects.shape.fields[k], objects.charts[k]); });
  for (const Body& body : bodies)
    if (body.graph.position.empty()) return std::nullopt;
  DirectedFit best = bestFit(bodies, [&](size_t k) { return bodies[k].graph.position; });
  if (best.fit.hopeless) return std::nullopt;
  if (!kSure.hold(best.fit))
    for (const Matching& start : limbCandidates()) {
      if (kSure.hold(best.fit)) break;
      if (start.limbPoints.empty()) continue;
      DirectedFit other = bestFit(bodies, [&](size_t k) { return carriedNodes(objects, bodies, start, k); });
      if (badness(other.fit) < badness(best.fit)) best = std::move(other);
    }
  const ElasticFit& fit = best.fit;
  if (!kMost.hold(fit)) return std::nullopt;
  Bending bending{followBody(objects, matching, pointsOf(objects, bodies, fit, best.from, 1 - best.from)),
                  kSure.hold(fit)};
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
