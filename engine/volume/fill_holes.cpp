#include "engine/volume/fill_holes.h"

#include "engine/numerics/disjoint_sets.h"
#include "engine/numerics/edge_table.h"

#include <algorithm>
#include <limits>

namespace slicemorph {

namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;
using Index = std::uint32_t;

constexpr Index kNotInWalk = std::numeric_limits<Index>::max();
/// The least-area search takes cubic time: for 400 edges it evaluates 10 million triangles.
constexpr size_t kMostLeastAreaEdges = 400;

double edgeLength(const std::vector<Vec3s>& points, Index a, Index b) {
  return (Vec3d(points[b]) - Vec3d(points[a])).length();
}

/// The triangulation of least area of a closed polygon in space, by dynamic programming [BS95].
std::vector<Vec3I> fillLeastArea(const std::vector<Vec3s>& points, const PointLoop& loop) {
  const size_t n = loop.size();
  std::vector<double> cost(n * n, 0.0);
  std::vector<Index> split(n * n, 0);
  for (size_t span = 2; span < n; ++span) {
    for (size_t i = 0; i + span < n; ++i) {
      const size_t j = i + span;
      const Vec3d a = Vec3d(points[loop[i]]), b = Vec3d(points[loop[j]]);
      double best = std::numeric_limits<double>::infinity();
      for (size_t k = i + 1; k < j; ++k) {
        const Vec3d c = Vec3d(points[loop[k]]);
        const double area = cost[i * n + k] + cost[k * n + j] + 0.5 * (b - a).cross(c - a).length();
        if (area < best) {
          best = area;
          split[i * n + j] = Index(k);
        }
      }
      cost[i * n + j] = best;
    }
  }
  std::vector<Vec3I> triangles;
  std::vector<std::pair<size_t, size_t>> open{{0, n - 1}};
  while (!open.empty()) {
    const auto [i, j] = open.back();
    open.pop_back();
    if (j - i < 2) continue;
    const size_t k = split[i * n + j];
    triangles.emplace_back(loop[i], loop[k], loop[j]);
    open.emplace_back(i, k);
    open.emplace_back(k, j);
  }
  return triangles;
}

}  // namespace

BoundaryLoops findBoundary(const std::vector<Vec3I>& triangles, size_t pointCount) {
  const EdgeTable edges(triangles);
  BoundaryLoops result;
  std::vector<std::pair<Index, Index>> next;  // (from, to); filling triangles run against the half edge
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) == 1) next.emplace_back(edges.half(e, 0).to(), edges.half(e, 0).from());
  }
  std::sort(next.begin(), next.end());
  result.edges = next.size();
  std::vector<bool> used(next.size(), false);
  std::vector<Index> positionInWalk(pointCount, kNotInWalk);
  const auto leave = [&](Index from) {
    auto it = std::lower_bound(next.begin(), next.end(), std::make_pair(from, Index(0)));
    while (it != next.end() && it->first == from && used[size_t(it - next.begin())]) ++it;
    return it != next.end() && it->first == from ? size_t(it - next.begin()) : next.size();
  };
  for (size_t start = 0; start < next.size(); ++start) {
    if (used[start]) continue;
    PointLoop walk{next[start].first};
    positionInWalk[walk[0]] = 0;
    for (size_t e = leave(walk.back()); e < next.size(); e = leave(walk.back())) {
      used[e] = true;
      const Index to = next[e].second, position = positionInWalk[to];
      if (position == kNotInWalk) {
        positionInWalk[to] = Index(walk.size());
        walk.push_back(to);
        continue;
      }
      result.loops.emplace_back(walk.begin() + position, walk.end());
      for (size_t i = position + 1; i < walk.size(); ++i) positionInWalk[walk[i]] = kNotInWalk;
      walk.resize(position + 1);
    }
    result.strays += walk.size() - 1;
    for (Index i : walk) positionInWalk[i] = kNotInWalk;
  }
  return result;
}

double loopLength(const std::vector<Vec3s>& points, const PointLoop& loop) {
  double length = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    length += edgeLength(points, loop[i], loop[(i + 1) % loop.size()]);
  }
  return length;
}

std::vector<double> boundaryParts(const Mesh& mesh) {
  const EdgeTable edges(mesh.triangles);
  DisjointSets parts(mesh.points.size());
  std::vector<double> lengths(mesh.points.size(), 0.0);
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) == 1) parts.join(edges.half(e, 0).low, edges.half(e, 0).high);
  }
  for (size_t e = 0; e < edges.count(); ++e) {
    const HalfEdge& h = edges.half(e, 0);
    if (edges.faces(e) == 1) lengths[parts.find(h.low)] += edgeLength(mesh.points, h.low, h.high);
  }
  lengths.erase(std::remove(lengths.begin(), lengths.end(), 0.0), lengths.end());
  return lengths;
}

void fillHole(Mesh& mesh, const PointLoop& loop) {
  if (loop.size() <= kMostLeastAreaEdges) {
    for (const Vec3I& t : fillLeastArea(mesh.points, loop)) mesh.triangles.push_back(t);
    return;
  }
  Vec3d centre(0.0);
  for (Index i : loop) centre += Vec3d(mesh.points[i]);
  const Index middle = Index(mesh.points.size());
  mesh.points.emplace_back(Vec3s(centre / double(loop.size())));
  for (size_t i = 0; i < loop.size(); ++i) {
    mesh.triangles.emplace_back(loop[i], loop[(i + 1) % loop.size()], middle);
  }
}

}  // namespace slicemorph
