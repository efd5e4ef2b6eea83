#include "engine/match/body_graph.h"

#include "engine/spine/geodesics.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

/// Nodes along an object's longest side, and of the whole object, at most. On recorded motions (samba,
/// horse_collapse) 24 along the side were as good as 32 and 40.
constexpr int kAlong = 32;
constexpr size_t kMostNodes = 2200;
/// An edge counts whose middle is outside by no more than this share of the spacing.
constexpr double kGap = 0.1;
/// Added to distances in spacings where they are turned into weights of a binding, so that none is infinite.
constexpr double kSoftest = 0.05;

}  // namespace

BodyGraph::Binding BodyGraph::bind(const Vec3d& point) const {
  size_t nearest = 0;
  double least = std::numeric_limits<double>::max();
  for (size_t i = 0; i < position.size(); ++i)
    if (const double d = (position[i] - point).lengthSqr(); d < least) least = d, nearest = i;
  std::vector<std::pair<double, int>> around{{least, int(nearest)}};
  for (int n : neighbours[nearest]) around.emplace_back((position[size_t(n)] - point).lengthSqr(), n);
  std::sort(around.begin(), around.end());
  Binding binding{};
  const size_t count = std::min(around.size(), size_t(Binding::kNodes));
  double sum = 0;
  double weight[Binding::kNodes] = {};
  for (size_t i = 0; i < count; ++i) {
    const double d = std::sqrt(around[i].first) / spacing + kSoftest;
    weight[i] = 1 / (d * d), sum += weight[i];
  }
  for (size_t i = 0; i < size_t(Binding::kNodes); ++i) {
    binding.node[i] = i < count ? around[i].second : int(nearest);
    binding.weight[i] = float(weight[i] / sum);
  }
  return binding;
}

std::vector<double> BodyGraph::distancesFrom(size_t node) const {
  return shortestPaths(position.size(), node, [&](size_t i, const auto& visit) {
    for (int n : neighbours[i]) visit(size_t(n), (position[size_t(n)] - position[i]).length());
  });
}

BodyGraph bodyGraph(const DistanceField& field, const Chart& chart) {
  const InsideNodes inside(field, kMostNodes, kAlong);
  const Geodesics paths(inside);
  BodyGraph graph;
  graph.spacing = inside.spacing / chart.meanScale();
  std::vector<int> number(inside.position.size(), -1);
  for (size_t i = 0; i < inside.position.size(); ++i) {
    if (!(inside.bodyShare(i) > 0)) continue;
    number[i] = int(graph.position.size());
    graph.position.push_back(chart.toChart(inside.position[i]));
    graph.share.push_back(inside.bodyShare(i));
    const double depth = inside.depth[i] / chart.meanScale();
    if (number[i] == 0 || depth > graph.depth) graph.depth = depth, graph.deepest = size_t(number[i]);
  }
  graph.neighbours.resize(graph.position.size());
  for (size_t i = 0; i < inside.position.size(); ++i)
    for (const Geodesics::Neighbour& n : paths.neighbours(i)) {
      if (n.node < i || number[i] < 0 || number[n.node] < 0) continue;
      const Vec3d middle = 0.5 * (inside.position[i] + inside.position[n.node]);
      if (!(field.coarse(middle) < kGap * inside.spacing)) continue;
      const double length = n.distance / inside.spacing;
      const int a = number[i], b = number[n.node];
      const float weight =
          std::sqrt(float(inside.bodyShare(i)) * float(inside.bodyShare(n.node))) / float(length * length);
      graph.edges.push_back({a, b, weight});
      graph.neighbours[size_t(a)].push_back(b), graph.neighbours[size_t(b)].push_back(a);
    }
  return graph;
}

}  // namespace slicemorph
