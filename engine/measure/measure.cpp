#include "engine/measure/measure.h"

#include "engine/numerics/disjoint_sets.h"
#include "engine/numerics/edge_table.h"
#include "engine/volume/voxelise.h"

#include <cstdint>

namespace slicemorph {
namespace {

using Index = DisjointSets::Index;

Index nextCorner(Index corner) { return corner % 3 == 2 ? corner - 2 : corner + 1; }

/// Joins half edges of opposite direction: their triangles are in one shell, their corners in one fan
/// about a point.
class Shells {
 public:
  explicit Shells(const Mesh& mesh)
      : shells_(mesh.triangles.size()), fans_(3 * mesh.triangles.size()), open_(mesh.triangles.size(), 0) {
    const EdgeTable edges(mesh.triangles);
    for (size_t e = 0; e < edges.count(); ++e) joinEdge(edges.begin(e), edges.end(e));
  }
  Index shellOf(Index triangle) { return shells_.find(triangle); }
  bool isFanRoot(Index corner) { return fans_.find(corner) == corner; }
  bool hasOpenEdge(Index triangle) const { return open_[triangle] != 0; }

 private:
  /// Pairs each forward half edge with a backward one; if more than two triangles share the edge,
  /// in their order.
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
      shells_.join(c / 3, d / 3);
      fans_.join(c, nextCorner(d));
      fans_.join(nextCorner(c), d);
    }
    for (; forward != end; forward = seek(forward + 1, true)) open_[forward->corner / 3] = 1;
    for (; backward != end; backward = seek(backward + 1, false)) open_[backward->corner / 3] = 1;
  }

  DisjointSets shells_, fans_;
  std::vector<char> open_;
};

/// Sums over one shell, stored at the index of its first triangle.
struct ShellSums {
  double volume = 0;
  std::int64_t faces = 0, fans = 0;
  bool open = false;
};

}  // namespace

ShapeMeasures measureMesh(const Mesh& mesh) {
  ShapeMeasures result;
  if (mesh.triangles.empty()) return result;
  // Volumes are relative to a point of the mesh: far from the origin the terms would cancel badly.
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
    // V - E + F of a closed triangle mesh, which has E = 3/2 F, is 2 - 2 genus.
    if (!shell.open) result.genus += int(1 - (shell.fans - shell.faces / 2) / 2);
  }
  return result;
}

ShapeMeasures measureShape(const FloatGrid& levelSet) { return measureMesh(surfaceOf(levelSet)); }

}  // namespace slicemorph
