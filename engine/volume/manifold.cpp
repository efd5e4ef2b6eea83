#include "engine/volume/manifold.h"

#include "slicemorph/errors.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <numeric>
#include <tuple>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;
using Index = std::uint32_t;

/// How far split points move towards their own faces, relative to the faces' size. Enough that readers that
/// weld equal coordinates do not join them again.
constexpr double kApart = 0.05;

/// The corners of all triangles grouped by point, with offsets in `starts`. Corner 3 t + k is corner k of
/// triangle t.
struct Corners {
  std::vector<Index> starts, corners;
};

Corners cornersByPoint(const Mesh& mesh) {
  Corners result;
  result.starts.assign(mesh.points.size() + 1, 0);
  for (const Vec3I& t : mesh.triangles) {
    for (int k = 0; k < 3; ++k) ++result.starts[t[k] + 1];
  }
  for (size_t i = 1; i < result.starts.size(); ++i) result.starts[i] += result.starts[i - 1];
  std::vector<Index> next(result.starts.begin(), result.starts.end() - 1);
  result.corners.resize(mesh.triangles.size() * 3);
  for (size_t c = 0; c < result.corners.size(); ++c) {
    result.corners[next[mesh.triangles[c / 3][int(c % 3)]]++] = Index(c);
  }
  return result;
}

/// The side from -> to of a triangle that is opposite to its corner at a given point.
struct Side {
  Index from, to, corner;
};

std::vector<Side> sidesAround(const Mesh& mesh, const Corners& corners, size_t point) {
  std::vector<Side> sides;
  sides.reserve(corners.starts[point + 1] - corners.starts[point]);
  for (Index i = corners.starts[point]; i < corners.starts[point + 1]; ++i) {
    const Index c = corners.corners[i];
    const Vec3I& t = mesh.triangles[c / 3];
    sides.push_back({t[int((c + 1 - c / 3 * 3) % 3)], t[int((c + 2 - c / 3 * 3) % 3)], c});
  }
  std::sort(sides.begin(), sides.end(), [](const Side& a, const Side& b) {
    return a.from != b.from ? a.from < b.from : a.corner < b.corner;
  });
  return sides;
}

enum class Fault : unsigned char { kNone, kEdge, kPoint, kOpen };

/// Splits the sides around a point into cycles, one per fan; empty if they do not close.
std::vector<std::vector<Side>> fansOf(const std::vector<Side>& sides) {
  std::vector<std::vector<Side>> fans;
  std::vector<bool> used(sides.size(), false);
  for (size_t start = 0; start < sides.size(); ++start) {
    if (used[start]) continue;
    std::vector<Side> fan;
    size_t i = start;
    while (!used[i]) {
      used[i] = true;
      fan.push_back(sides[i]);
      const auto next = std::lower_bound(sides.begin(), sides.end(), sides[i].to,
                                         [](const Side& side, Index from) { return side.from < from; });
      if (next == sides.end() || next->from != sides[i].to) return {};
      i = size_t(next - sides.begin());
    }
    if (i != start) return {};
    fans.push_back(std::move(fan));
  }
  return fans;
}

bool sameEnds(const std::vector<Side>& sides) {
  std::vector<Index> from, to;
  for (const Side& side : sides) {
    from.push_back(side.from);
    to.push_back(side.to);
  }
  std::sort(to.begin(), to.end());
  return from == to;
}

Fault faultAt(const std::vector<Side>& sides) {
  for (size_t i = 1; i < sides.size(); ++i) {
    if (sides[i].from == sides[i - 1].from) return sameEnds(sides) ? Fault::kEdge : Fault::kOpen;
  }
  const size_t fans = fansOf(sides).size();
  if (fans == 0 && !sides.empty()) return Fault::kOpen;
  return fans > 1 ? Fault::kPoint : Fault::kNone;
}

std::vector<size_t> pointsWith(Fault fault, const Mesh& mesh, const Corners& corners) {
  std::vector<Fault> faults(mesh.points.size(), Fault::kNone);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, faults.size(), 4096),
                    [&](const tbb::blocked_range<size_t>& r) {
                      for (size_t i = r.begin(); i < r.end(); ++i)
                        faults[i] = faultAt(sidesAround(mesh, corners, i));
                    });
  std::vector<size_t> found;
  for (size_t i = 0; i < faults.size(); ++i) {
    if (faults[i] == Fault::kOpen) throw GeometryError("the surface mesh is not closed");
    if (faults[i] == fault) found.push_back(i);
  }
  return found;
}

/// A triangle at the edge a-b, with the angle of its third point (`apex`) about a -> b.
struct EdgeFace {
  Index triangle, apex;
  bool forward;  // the triangle runs from a to b
  double angle;
};

std::vector<EdgeFace> facesAtEdge(const Mesh& mesh, const Corners& corners, Index a, Index b) {
  const Vec3d origin(mesh.points[a]);
  Vec3d axis = Vec3d(mesh.points[b]) - origin;
  if (!axis.normalize(0.0)) axis = Vec3d(0, 0, 1);
  Vec3d e1 = std::abs(axis.x()) < 0.6 ? Vec3d(1, 0, 0) : Vec3d(0, 1, 0);
  e1 = (e1 - axis * e1.dot(axis)).unit();
  const Vec3d e2 = axis.cross(e1);
  std::vector<EdgeFace> faces;
  for (const Side& side : sidesAround(mesh, corners, a)) {
    if (side.from != b && side.to != b) continue;
    const bool forward = side.from == b;
    const Index apex = forward ? side.to : side.from;
    const Vec3d p = Vec3d(mesh.points[apex]) - origin;
    faces.push_back({side.corner / 3, apex, forward, std::atan2(p.dot(e2), p.dot(e1))});
  }
  std::sort(faces.begin(), faces.end(), [](const EdgeFace& l, const EdgeFace& r) {
    return l.angle != r.angle ? l.angle < r.angle : l.triangle < r.triangle;
  });
  return faces;
}

/// Pairs of faces that bound the same solid wedge: turning about a -> b, the inside begins at a triangle that
/// runs b -> a and ends at one that runs a -> b.
std::vector<std::pair<EdgeFace, EdgeFace>> pairWedges(const std::vector<EdgeFace>& faces) {
  std::vector<std::pair<EdgeFace, EdgeFace>> pairs;
  std::vector<bool> used(faces.size(), false);
  for (size_t i = 0; i < faces.size(); ++i) {
    if (faces[i].forward) continue;
    for (size_t j = 1; j < faces.size(); ++j) {
      const size_t k = (i + j) % faces.size();
      if (!faces[k].forward || used[k]) continue;
      used[k] = true;
      pairs.emplace_back(faces[i], faces[k]);
      break;
    }
  }
  return pairs;
}

void splitTriangle(Mesh& mesh, Index triangle, Index a, Index b, Index middle) {
  Vec3I first = mesh.triangles[triangle], second = first;
  for (int k = 0; k < 3; ++k) {
    if (first[k] == b) first[k] = middle;
    if (second[k] == a) second[k] = middle;
  }
  mesh.triangles[triangle] = first;
  mesh.triangles.push_back(second);
}

/// Splits the edge a-b, with a separate middle point for each pair of triangles.
void splitEdge(Mesh& mesh, const std::vector<EdgeFace>& faces, Index a, Index b) {
  const Vec3d middle = 0.5 * (Vec3d(mesh.points[a]) + Vec3d(mesh.points[b]));
  for (const auto& [left, right] : pairWedges(faces)) {
    const Vec3d own = 0.5 * (Vec3d(mesh.points[left.apex]) + Vec3d(mesh.points[right.apex]));
    const Index point = Index(mesh.points.size());
    mesh.points.emplace_back(Vec3s(middle + kApart * (own - middle)));
    splitTriangle(mesh, left.triangle, a, b, point);
    splitTriangle(mesh, right.triangle, a, b, point);
  }
}

std::vector<std::pair<Index, Index>> crowdedEdges(const Mesh& mesh, const Corners& corners) {
  std::vector<std::pair<Index, Index>> edges;
  for (size_t a : pointsWith(Fault::kEdge, mesh, corners)) {
    const std::vector<Side> sides = sidesAround(mesh, corners, a);
    for (size_t i = 1; i < sides.size(); ++i) {
      if (sides[i].from == sides[i - 1].from && a < sides[i].from)
        edges.emplace_back(Index(a), sides[i].from);
    }
  }
  edges.erase(std::unique(edges.begin(), edges.end()), edges.end());
  return edges;
}

/// One pass over the edges with more than two faces; returns false if there were none.
bool splitEdges(Mesh& mesh) {
  const Corners corners = cornersByPoint(mesh);
  const std::vector<std::pair<Index, Index>> edges = crowdedEdges(mesh, corners);
  if (edges.empty()) return false;
  // `corners` describes the mesh before this pass: an edge at a triangle that was split already is left to
  // the next one.
  const Mesh before = mesh;
  std::vector<bool> touched(mesh.triangles.size(), false);
  for (const auto& [a, b] : edges) {
    const std::vector<EdgeFace> faces = facesAtEdge(before, corners, a, b);
    const auto isTouched = [&](const EdgeFace& face) { return touched[face.triangle]; };
    if (std::any_of(faces.begin(), faces.end(), isTouched)) continue;
    for (const EdgeFace& face : faces) touched[face.triangle] = true;
    splitEdge(mesh, faces, a, b);
  }
  return true;
}

/// The point, moved a little towards the centroid of its fan's rim.
Vec3s towards(const Mesh& mesh, const std::vector<Side>& fan, size_t point) {
  const Vec3d centre(mesh.points[point]);
  Vec3d rim(0.0);
  for (const Side& side : fan) rim += Vec3d(mesh.points[side.from]) / double(fan.size());
  return Vec3s(centre + kApart * (rim - centre));
}

void splitPoints(Mesh& mesh) {
  const Corners corners = cornersByPoint(mesh);
  for (size_t point : pointsWith(Fault::kPoint, mesh, corners)) {
    const std::vector<std::vector<Side>> fans = fansOf(sidesAround(mesh, corners, point));
    // The first fan keeps the point, the others get copies. All are moved from the original position, so the
    // first is processed last.
    for (size_t i = fans.size(); i-- > 0;) {
      const Vec3s moved = towards(mesh, fans[i], point);
      const Index target = i == 0 ? Index(point) : Index(mesh.points.size());
      if (i == 0) {
        mesh.points[point] = moved;
      } else {
        mesh.points.push_back(moved);
      }
      for (const Side& side : fans[i]) mesh.triangles[side.corner / 3][int(side.corner % 3)] = target;
    }
  }
}

/// Points with the same coordinates as another of smaller index.
std::vector<Index> coincidentPoints(const std::vector<Vec3s>& points) {
  std::vector<Index> order(points.size());
  std::iota(order.begin(), order.end(), 0);
  tbb::parallel_sort(order.begin(), order.end(), [&](Index a, Index b) {
    const Vec3s &p = points[a], &q = points[b];
    return std::make_tuple(p[0], p[1], p[2], a) < std::make_tuple(q[0], q[1], q[2], b);
  });
  std::vector<Index> found;
  for (size_t i = 1; i < order.size(); ++i) {
    if (points[order[i]] == points[order[i - 1]]) found.push_back(order[i]);
  }
  std::sort(found.begin(), found.end());
  return found;
}

/// Returns the number of points that still share their coordinates with another.
size_t separatePoints(Mesh& mesh) {
  std::vector<Index> coincident = coincidentPoints(mesh.points);
  if (coincident.empty()) return 0;
  const Corners corners = cornersByPoint(mesh);
  // Each round moves points a little further. A surface that has shrunk to a point or line
  // cannot be separated.
  for (int round = 0; round < 8 && !coincident.empty(); ++round) {
    for (Index point : coincident)
      mesh.points[point] = towards(mesh, sidesAround(mesh, corners, point), point);
    coincident = coincidentPoints(mesh.points);
  }
  return coincident.size();
}

}  // namespace

ManifoldMesh makeManifold(Mesh mesh) {
  while (splitEdges(mesh)) {
  }
  splitPoints(mesh);
  const size_t coincident = separatePoints(mesh);
  return {std::move(mesh), coincident};
}

}  // namespace slicemorph
