#include "engine/match/elastic_matching.h"

#include "engine/match/elastic_fit.h"
#include "engine/match/follow_limbs.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <cstdio>
#include <utility>

namespace slicemorph {

namespace {

/// Samples of each surface that the bodies are bent by.
constexpr int kSamples = 3000;
/// Beyond these the objects are not one body in two poses: strain, and distance left over in sizes of the
/// objects. See tests/engine/match/elastic_matching_test.cpp.
constexpr double kMostStrain = 0.27, kMostResidual = 0.02;

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

Vec3d meanOf(const std::vector<Vec3d>& points) {
  Vec3d sum(0.0);
  for (const Vec3d& p : points) sum += p / double(points.size());
  return sum;
}

/// The correspondences that a fit of object `from` to object `to` gives: of its nodes and its surface.
std::vector<Correspondence> pointsOf(const MatchObjects& objects, const std::vector<Body>& bodies,
                                     const ElasticFit& fit, size_t from, size_t to) {
  const BodyGraph& graph = bodies[from].graph;
  const ElasticFit half = halfWay(graph, fit, 0.5 * (meanOf(graph.position) + meanOf(fit.position)));
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

}  // namespace

std::optional<Matching> elasticMatching(const MatchObjects& objects, const Matching& matching) {
  if (objects.count() != 2 || !objects.features.empty()) return std::nullopt;
  std::vector<Body> bodies(2);
  tbb::parallel_for(size_t(0), size_t(2),
                    [&](size_t k) { bodies[k] = bodyOf(*objects.shape.fields[k], objects.charts[k]); });
  for (const Body& body : bodies)
    if (body.graph.position.empty()) return std::nullopt;
  ElasticFit fits[2];
  tbb::parallel_for(size_t(0), size_t(2), [&](size_t k) {
    fits[k] =
        fitElastically(bodies[k].graph, bodies[k].surface, bodies[1 - k].surface, bodies[k].graph.position);
  });
  const auto badness = [&](const ElasticFit& fit) {
    return fit.strain / kMostStrain + fit.residual / kMostResidual;
  };
  const size_t from = badness(fits[1]) < badness(fits[0]) ? 1 : 0;
  const ElasticFit& fit = fits[from];
  char text[160];
  std::snprintf(text, sizeof text, "bent onto each other: strain %.3f and %.3f, left over %.4f and %.4f",
                fits[0].strain, fits[1].strain, fits[0].residual, fits[1].residual);
  if (!(fit.strain < kMostStrain && fit.residual < kMostResidual)) return std::nullopt;
  Matching result = followBody(objects, matching, pointsOf(objects, bodies, fit, from, 1 - from));
  result.notes.push_back({"match.elastic", Severity::kDetail, "", text});
  std::snprintf(text, sizeof text, "bent: overlap %.3f", result.overlap);
  result.notes.push_back({"match.elastic", Severity::kDetail, "", text});
  return result;
}

}  // namespace slicemorph
