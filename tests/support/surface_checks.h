#pragma once

#include "slicemorph/mesh.h"

#include <algorithm>
#include <array>
#include <map>
#include <string>
#include <tuple>
#include <vector>

/// Checkers of surface meshes, shared by the tests. Each returns the first fault; empty: there is none.
namespace slicemorph::checks {

/// Every edge is in exactly two triangles, in opposite directions, and every point in exactly one fan.
inline std::string closedAndManifold(const Mesh& mesh) {
  std::vector<std::pair<unsigned, unsigned>> edges;
  std::vector<std::vector<std::pair<unsigned, unsigned>>> sides(mesh.points.size());
  for (const openvdb::Vec3I& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) {
      if (t[k] >= mesh.points.size()) return "a triangle refers to no point";
      edges.emplace_back(t[k], t[(k + 1) % 3]);
      sides[t[k]].emplace_back(t[(k + 1) % 3], t[(k + 2) % 3]);
    }
  }
  std::sort(edges.begin(), edges.end());
  for (size_t i = 0; i < edges.size(); ++i) {
    const auto [a, b] = edges[i];
    if (a == b) return "a triangle has a point twice";
    if (i > 0 && edges[i] == edges[i - 1])
      return "edge " + std::to_string(a) + "-" + std::to_string(b) + " twice";
    if (!std::binary_search(edges.begin(), edges.end(), std::make_pair(b, a))) {
      return "edge " + std::to_string(a) + "-" + std::to_string(b) + " is open";
    }
  }
  for (size_t p = 0; p < sides.size(); ++p) {
    if (sides[p].empty()) return "point " + std::to_string(p) + " is unused";
    const std::map<unsigned, unsigned> next(sides[p].begin(), sides[p].end());
    size_t steps = 0;
    unsigned at = sides[p][0].first;
    do {
      at = next.at(at);
      ++steps;
    } while (at != sides[p][0].first && steps <= next.size());
    if (steps != next.size()) return "point " + std::to_string(p) + " joins several fans";
  }
  return "";
}

/// No two points have the same coordinates.
inline std::string distinctPoints(const Mesh& mesh) {
  std::vector<std::array<float, 3>> points;
  for (const openvdb::Vec3s& p : mesh.points) points.push_back({p[0], p[1], p[2]});
  std::sort(points.begin(), points.end());
  const auto same = std::adjacent_find(points.begin(), points.end());
  return same == points.end() ? "" : "two points at " + std::to_string((*same)[0]);
}

/// Signed volume, world units cubed; positive where faces point outwards.
inline double volumeOf(const Mesh& mesh) {
  double volume = 0;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const openvdb::Vec3d a(mesh.points[t[0]]), b(mesh.points[t[1]]), c(mesh.points[t[2]]);
    volume += a.dot(b.cross(c)) / 6;
  }
  return volume;
}

/// The bytes of values, for comparing results.
template <typename T>
std::string bytesOf(const std::vector<T>& values) {
  return std::string(reinterpret_cast<const char*>(values.data()), values.size() * sizeof(T));
}

}  // namespace slicemorph::checks
