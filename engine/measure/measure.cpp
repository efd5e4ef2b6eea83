#include "engine/measure/measure.h"

#include "engine/volume/voxelise.h"

#include <algorithm>
#include <cstdint>
#include <numeric>
#include <tuple>

namespace slicemorph {
namespace {

using Index = std::uint32_t;

class DisjointSets {
 public:
  explicit DisjointSets(size_t count) : parent_(count) {
    std::iota(parent_.begin(), parent_.end(), Index(0));
  }
  Index find(Index i) {
    while (parent_[i] != i) i = parent_[i] = parent_[parent_[i]];
    return i;
  }
  /// The smaller index stays the root, so the result does not depend on the order of the unions.
  void unite(Index a, Index b) {
    a = find(a), b = find(b);
    if (a < b) parent_[b] = a;
    if (b < a) parent_[a] = b;
  }

 private:
  std::vector<Index> parent_;
};

/// Corner 3 t + i of triangle t, and the half edge that leaves it.
Index nextCorner(Index corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

struct HalfEdge {
  Index high;  ///< the larger of its two points; the smaller one is the bucket
  Index corner;
  bool forward;  ///< from the smaller to the larger point
};

/// Half edges in buckets by their smaller point: `first[p]` to `first[p + 1]`.
struct HalfEdgeTable {
  std::vector<Index> first;
  std::vector<HalfEdge> edges;
};

HalfEdgeTable sortHalfEdges(const Mesh& mesh) {
  HalfEdgeTable table;
  table.first.assign(mesh.points.size() + 2, 0);
  table.edges.resize(3 * mesh.triangles.size());
  const auto forEach = [&](auto&& visit) {
    for (Index t = 0; t < mesh.triangles.size(); ++t)
      for (int i = 0; i < 3; ++i) visit(3 * t + i, mesh.triangles[t][i], mesh.triangles[t][(i + 1) % 3]);
  };
  forEach([&](Index, Index p, Index q) { ++table.first[std::min(p, q) + 2]; });
  std::partial_sum(table.first.begin(), table.first.end(), table.first.begin());
  forEach([&](Index corner, Index p, Index q) {
    table.edges[table.first[std::min(p, q) + 1]++] = {std::max(p, q), corner, p < q};
  });
  table.first.pop_back();
  return table;
}

/// Joins half edges of opposite direction: their triangles belong to one shell, their corners to one fan
/// about a point.
class Shells {
 public:
  explicit Shells(const Mesh& mesh)
      : shells_(mesh.triangles.size()), fans_(3 * mesh.triangles.size()), open_(mesh.triangles.size(), 0) {
    HalfEdgeTable table = sortHalfEdges(mesh);
    for (size_t p = 0; p < mesh.points.size(); ++p)
      joinBucket(table.edges.data() + table.first[p], table.edges.data() + table.first[p + 1]);
  }
  Index shellOf(Index triangle) { return shells_.find(triangle); }
  bool isFanRoot(Index corner) { return fans_.find(corner) == corner; }
  bool hasOpenEdge(Index triangle) const { return open_[triangle] != 0; }

 private:
  void joinBucket(HalfEdge* begin, HalfEdge* end) {
    std::sort(begin, end, [](const HalfEdge& a, const HalfEdge& b) {
      return std::tie(a.high, a.corner) < std::tie(b.high, b.corner);
    });
    while (begin != end) {
      HalfEdge* last = begin;
      while (last != end && last->high == begin->high) ++last;
      joinEdge(begin, last);
      begin = last;
    }
  }
  /// Pairs each forward half edge with a backward one; where more than two triangles share the edge, in their
  /// order.
  void joinEdge(const HalfEdge* begin, const HalfEdge* end) {
    const HalfEdge *forward = begin, *backward = begin;
    const auto seek = [end](const HalfEdge* e, bool direction) {
      while (e != end && e->forward != direction) ++e;
      return e;
    };
    forward = seek(forward, true), backward = seek(backward, false);
    for (; forward != end && backward != end;
         forward = seek(forward + 1, true), backward = seek(backward + 1, false)) {
      const Index c = forward->corner, d = backward->corner;
      shells_.unite(c / 3, d / 3);
      fans_.unite(c, nextCorner(d));
      fans_.unite(nextCorner(c), d);
    }
    for (; forward != end; forward = seek(forward + 1, true)) open_[forward->corner / 3] = 1;
    for (; backward != end; backward = seek(backward + 1, false)) open_[backward->corner / 3] = 1;
  }

  DisjointSets shells_, fans_;
  std::vector<char> open_;
};

/// Of one shell, kept at the index of its first triangle.
struct ShellSums {
  double volume = 0;
  std::int64_t faces = 0, fans = 0;
  bool open = false;
};

}  // namespace

ShapeMeasures measureMesh(const Mesh& mesh) {
  ShapeMeasures result;
  if (mesh.triangles.empty()) return result;
  // Volumes are taken about a point of the mesh: far from the origin the terms would cancel badly.
  const Vec3d origin(mesh.points[mesh.triangles[0][0]]);
  Shells shells(mesh);
  std::vector<ShellSums> sums(mesh.triangles.size());
  for (Index t = 0; t < mesh.triangles.size(); ++t) {
    const auto& triangle = mesh.triangles[t];
    const Vec3d a = Vec3d(mesh.points[triangle[0]]) - origin, b = Vec3d(mesh.points[triangle[1]]) - origin,
                c = Vec3d(mesh.points[triangle[2]]) - origin;
    ShellSums& shell = sums[shells.shellOf(t)];
    shell.volume += a.dot(b.cross(c)) / 6;
    result.area += (b - a).cross(c - a).length() / 2;
    ++shell.faces;
    for (Index corner = 3 * t; corner < 3 * t + 3; ++corner) shell.fans += shells.isFanRoot(corner);
    shell.open |= shells.hasOpenEdge(t);
  }
  for (const ShellSums& shell : sums) {
    if (!shell.faces) continue;
    result.volume += shell.volume;
    result.pieces += shell.volume > 0;
    // V - E + F of a closed triangle surface, whose edges are 3/2 its faces, is 2 - 2 genus.
    if (!shell.open) result.genus += int(1 - (shell.fans - shell.faces / 2) / 2);
  }
  return result;
}

ShapeMeasures measureShape(const FloatGrid& levelSet) { return measureMesh(surfaceOf(levelSet)); }

}  // namespace slicemorph
