#include "engine/volume/repair_mesh.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>
#include <sstream>
#include <tuple>

namespace slicemorph {
namespace {

using openvdb::Vec2d;
using openvdb::Vec3I;
using openvdb::Vec3s;
using Index = std::uint32_t;

constexpr Index kNone = std::numeric_limits<Index>::max();

/// Holes with more edges get a fan around their centroid: the least-area search takes cubic time.
constexpr size_t kLargestLeastArea = 400;

Vec3d position(const std::vector<Vec3s>& points, Index i) { return Vec3d(points[i]); }

std::string plural(size_t count, const std::string& noun, const std::string& more = "s") {
  return std::to_string(count) + " " + noun + (count == 1 ? "" : more);
}

std::string number(double value) {
  std::ostringstream text;
  text.precision(4);
  text << value;
  return text.str();
}

// ---------------------------------------------------------------- points

struct Welded {
  std::vector<Vec3s> points;    // distinct coordinates, in the order of first use
  std::vector<Index> newIndex;  // of every old point; kNone: no face uses it
  size_t unused = 0, merged = 0;
};

bool lessByPosition(const Vec3s& a, const Vec3s& b) {
  for (int i = 0; i < 3; ++i) {
    if (a[i] != b[i]) return a[i] < b[i];
  }
  return false;
}

Welded weld(const PolygonMesh& mesh) {
  const size_t count = mesh.points.size();
  std::vector<Index> order(count), first(count);
  std::iota(order.begin(), order.end(), 0);
  std::stable_sort(order.begin(), order.end(),
                   [&](Index a, Index b) { return lessByPosition(mesh.points[a], mesh.points[b]); });
  for (size_t i = 0; i < count; ++i) {
    const bool same = i > 0 && mesh.points[order[i]] == mesh.points[order[i - 1]];
    first[order[i]] = same ? first[order[i - 1]] : order[i];
  }
  std::vector<bool> used(count, false);
  for (Index corner : mesh.corners) used[corner] = true;

  Welded result;
  result.newIndex.assign(count, kNone);
  std::vector<Index> kept(count, kNone);
  for (size_t i = 0; i < count; ++i) {
    if (!used[i]) {
      ++result.unused;
      continue;
    }
    Index& target = kept[first[i]];
    if (target == kNone) {
      target = Index(result.points.size());
      result.points.push_back(mesh.points[i]);
    } else {
      ++result.merged;
    }
    result.newIndex[i] = target;
  }
  result.merged -= std::min(result.merged, mesh.importCopies);
  result.unused += mesh.importDropped;
  return result;
}

// ---------------------------------------------------------------- faces to triangles

/// Coordinates of a polygon in the plane of its Newell normal, wound counter-clockwise.
std::vector<Vec2d> flatten(const std::vector<Vec3s>& points, const std::vector<Index>& face) {
  Vec3d normal(0.0);
  const Vec3d origin = position(points, face[0]);
  for (size_t i = 1; i + 1 < face.size(); ++i) {
    normal += (position(points, face[i]) - origin).cross(position(points, face[i + 1]) - origin);
  }
  if (!normal.normalize(0.0)) normal = Vec3d(0, 0, 1);
  const int smallest = std::abs(normal.x()) < std::abs(normal.y())
                           ? (std::abs(normal.x()) < std::abs(normal.z()) ? 0 : 2)
                           : (std::abs(normal.y()) < std::abs(normal.z()) ? 1 : 2);
  Vec3d axis(0.0);
  axis[smallest] = 1;
  const Vec3d e1 = axis.cross(normal).unit(), e2 = normal.cross(e1);
  std::vector<Vec2d> flat;
  flat.reserve(face.size());
  for (Index i : face) {
    const Vec3d p = position(points, i) - origin;
    flat.emplace_back(p.dot(e1), p.dot(e2));
  }
  return flat;
}

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The corner of `ring` (positions in the face) that is best cut off: an ear, as far from flat as can be.
size_t bestEar(const std::vector<Vec2d>& flat, const std::vector<Index>& ring) {
  const size_t n = ring.size();
  size_t best = 0;
  double bestScore = -std::numeric_limits<double>::infinity();
  for (size_t i = 0; i < n; ++i) {
    const Vec2d &a = flat[ring[(i + n - 1) % n]], &b = flat[ring[i]], &c = flat[ring[(i + 1) % n]];
    const double area = turn(a, b, c);
    bool ear = area > 0;
    for (size_t j = 0; ear && j + 3 < n; ++j) {
      const Vec2d& p = flat[ring[(i + 2 + j) % n]];
      ear = !(turn(a, b, p) >= 0 && turn(b, c, p) >= 0 && turn(c, a, p) >= 0);
    }
    const double sides = (b - a).lengthSqr() + (c - b).lengthSqr() + (a - c).lengthSqr();
    const double quality = sides > 0 ? area / sides : 0;
    // A crossed or flat polygon may have no ear: the roundest corner then still ends the loop.
    const double score = ear ? quality : quality - 10;
    if (score > bestScore) {
      bestScore = score;
      best = i;
    }
  }
  return best;
}

/// Ear clipping (Meisters 1975); concave faces keep their outline.
std::vector<Vec3I> clipEars(const std::vector<Vec3s>& points, const std::vector<Index>& face) {
  std::vector<Vec3I> triangles;
  const std::vector<Vec2d> flat = flatten(points, face);
  std::vector<Index> ring(face.size());
  std::iota(ring.begin(), ring.end(), 0);
  while (ring.size() > 3) {
    const size_t n = ring.size(), ear = bestEar(flat, ring);
    triangles.emplace_back(face[ring[(ear + n - 1) % n]], face[ring[ear]], face[ring[(ear + 1) % n]]);
    ring.erase(ring.begin() + ptrdiff_t(ear));
  }
  triangles.emplace_back(face[ring[0]], face[ring[1]], face[ring[2]]);
  return triangles;
}

struct Triangulated {
  std::vector<Vec3I> triangles;
  size_t polygons = 0, degenerate = 0, duplicate = 0;
};

std::vector<Index> distinctCorners(const PolygonMesh& mesh, const Welded& welded, size_t f) {
  std::vector<Index> face;
  for (Index c = mesh.faceStarts[f]; c < mesh.faceStarts[f + 1]; ++c) {
    const Index corner = welded.newIndex[mesh.corners[c]];
    if (face.empty() || face.back() != corner) face.push_back(corner);
  }
  while (face.size() > 1 && face.front() == face.back()) face.pop_back();
  return face;
}

bool isDegenerate(const Vec3I& t) { return t[0] == t[1] || t[1] == t[2] || t[2] == t[0]; }

/// Keeps the first of the triangles with the same three points, whatever their winding.
size_t dropDuplicates(std::vector<Vec3I>& triangles) {
  using Key = std::array<Index, 4>;
  std::vector<Key> keys(triangles.size());
  for (size_t i = 0; i < triangles.size(); ++i) {
    Vec3I t = triangles[i];
    std::sort(&t[0], &t[0] + 3);
    keys[i] = {t[0], t[1], t[2], Index(i)};
  }
  std::sort(keys.begin(), keys.end());
  std::vector<bool> drop(triangles.size(), false);
  for (size_t i = 1; i < keys.size(); ++i) {
    drop[keys[i][3]] = std::equal(keys[i].begin(), keys[i].begin() + 3, keys[i - 1].begin());
  }
  size_t kept = 0;
  for (size_t i = 0; i < triangles.size(); ++i) {
    if (!drop[i]) triangles[kept++] = triangles[i];
  }
  const size_t dropped = triangles.size() - kept;
  triangles.resize(kept);
  return dropped;
}

Triangulated triangulate(const PolygonMesh& mesh, const Welded& welded) {
  Triangulated result;
  for (size_t f = 0; f < mesh.faceCount(); ++f) {
    const std::vector<Index> face = distinctCorners(mesh, welded, f);
    if (face.size() < 3) {
      ++result.degenerate;
      continue;
    }
    if (face.size() == 3) {
      result.triangles.emplace_back(face[0], face[1], face[2]);
    } else {
      ++result.polygons;
      for (const Vec3I& t : clipEars(welded.points, face)) result.triangles.push_back(t);
    }
  }
  const auto end = std::remove_if(result.triangles.begin(), result.triangles.end(), isDegenerate);
  result.degenerate += size_t(result.triangles.end() - end);
  result.triangles.erase(end, result.triangles.end());
  result.duplicate = dropDuplicates(result.triangles);
  return result;
}

// ---------------------------------------------------------------- edges, shells, winding

struct HalfEdge {
  Index low, high, triangle;
  bool forward;  // the triangle runs from low to high

  Index from() const { return forward ? low : high; }
  Index to() const { return forward ? high : low; }
};

/// All half edges, those of one edge side by side.
struct Edges {
  std::vector<HalfEdge> halves;
  std::vector<Index> starts;  // edges + 1 offsets into `halves`

  size_t count() const { return starts.size() - 1; }
  size_t faces(size_t edge) const { return starts[edge + 1] - starts[edge]; }
  const HalfEdge& half(size_t edge, size_t i) const { return halves[starts[edge] + i]; }
};

Edges collectEdges(const std::vector<Vec3I>& triangles) {
  Edges edges;
  edges.halves.reserve(triangles.size() * 3);
  for (size_t t = 0; t < triangles.size(); ++t) {
    for (int k = 0; k < 3; ++k) {
      const Index a = triangles[t][k], b = triangles[t][(k + 1) % 3];
      edges.halves.push_back({std::min(a, b), std::max(a, b), Index(t), a < b});
    }
  }
  std::sort(edges.halves.begin(), edges.halves.end(), [](const HalfEdge& a, const HalfEdge& b) {
    return std::tie(a.low, a.high, a.triangle) < std::tie(b.low, b.high, b.triangle);
  });
  for (size_t i = 0; i < edges.halves.size(); ++i) {
    const HalfEdge& h = edges.halves[i];
    if (i == 0 || h.low != edges.halves[i - 1].low || h.high != edges.halves[i - 1].high) {
      edges.starts.push_back(Index(i));
    }
  }
  edges.starts.push_back(Index(edges.halves.size()));
  return edges;
}

/// Disjoint sets of triangles that also carry whether a triangle is wound against its set's root.
class Sets {
 public:
  explicit Sets(size_t count) : parent_(count), flip_(count, 0) {
    std::iota(parent_.begin(), parent_.end(), 0);
  }

  Index root(Index i) {
    flipped(i);
    return parent_[i];
  }
  bool flipped(Index i) {
    Index top = i;
    unsigned char flip = 0;
    while (parent_[top] != top) {
      flip ^= flip_[top];
      top = parent_[top];
    }
    const unsigned char result = flip;
    while (parent_[i] != top && i != top) {
      const Index next = parent_[i];
      const unsigned char own = flip_[i];
      parent_[i] = top;
      flip_[i] = flip;
      flip ^= own;
      i = next;
    }
    return result != 0;
  }
  /// Joins two sets; false where they are one already and `opposite` contradicts it.
  bool join(Index a, Index b, bool opposite) {
    const bool flip = (flipped(a) != flipped(b)) != opposite;
    const Index ra = root(a), rb = root(b);
    if (ra == rb) return !flip;
    parent_[std::max(ra, rb)] = std::min(ra, rb);
    flip_[std::max(ra, rb)] = flip;
    return true;
  }

 private:
  std::vector<Index> parent_;
  std::vector<unsigned char> flip_;
};

double signedVolume(const std::vector<Vec3s>& points, const Vec3I& t, const Vec3d& origin) {
  const Vec3d a = position(points, t[0]) - origin;
  return a.dot((position(points, t[1]) - origin).cross(position(points, t[2]) - origin)) / 6;
}

struct Winding {
  std::vector<Index> patch;  // per triangle: its set across edges with two faces
  std::vector<Index> shell;  // per triangle: its set across any edge
  size_t shells = 0, nonManifold = 0, twisted = 0, turned = 0;
};

/// Makes the winding agree across edges with two faces; each patch follows its majority.
Winding agreeOnWinding(std::vector<Vec3I>& triangles) {
  const Edges edges = collectEdges(triangles);
  const size_t count = triangles.size();
  Sets patches(count), shells(count);
  Winding result;
  for (size_t e = 0; e < edges.count(); ++e) {
    for (size_t i = 1; i < edges.faces(e); ++i) {
      shells.join(edges.half(e, 0).triangle, edges.half(e, i).triangle, false);
    }
    if (edges.faces(e) > 2) ++result.nonManifold;
    if (edges.faces(e) != 2) continue;
    const HalfEdge &a = edges.half(e, 0), &b = edges.half(e, 1);
    if (!patches.join(a.triangle, b.triangle, a.forward == b.forward)) ++result.twisted;
  }
  std::vector<ptrdiff_t> against(count, 0);
  result.patch.resize(count);
  result.shell.resize(count);
  for (size_t t = 0; t < count; ++t) {
    result.patch[t] = patches.root(Index(t));
    result.shell[t] = shells.root(Index(t));
    result.shells += result.shell[t] == t;
    against[result.patch[t]] += patches.flipped(Index(t)) ? 1 : -1;
  }
  for (size_t t = 0; t < count; ++t) {
    if (patches.flipped(Index(t)) != (against[result.patch[t]] > 0)) {
      std::swap(triangles[t][1], triangles[t][2]);
      ++result.turned;
    }
  }
  return result;
}

// ---------------------------------------------------------------- holes

using Loop = std::vector<Index>;

struct Boundary {
  std::vector<Loop> loops;  // in the direction that triangles filling them run
  size_t edges = 0;
  size_t strays = 0;  // edges that close no loop, because the winding disagrees there
};

/// Cuts a walk along boundary edges into loops that pass no point twice.
Boundary findBoundary(const std::vector<Vec3I>& triangles, size_t pointCount) {
  const Edges edges = collectEdges(triangles);
  Boundary result;
  std::vector<std::pair<Index, Index>> next;  // (from, to), a filling triangle runs against the half edge
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) == 1) next.emplace_back(edges.half(e, 0).to(), edges.half(e, 0).from());
  }
  std::sort(next.begin(), next.end());
  result.edges = next.size();
  std::vector<bool> used(next.size(), false);
  std::vector<Index> placeInWalk(pointCount, kNone);
  const auto leave = [&](Index from) {
    auto it = std::lower_bound(next.begin(), next.end(), std::make_pair(from, Index(0)));
    while (it != next.end() && it->first == from && used[size_t(it - next.begin())]) ++it;
    return it != next.end() && it->first == from ? size_t(it - next.begin()) : next.size();
  };
  for (size_t start = 0; start < next.size(); ++start) {
    if (used[start]) continue;
    Loop walk{next[start].first};
    placeInWalk[walk[0]] = 0;
    for (size_t e = leave(walk.back()); e < next.size(); e = leave(walk.back())) {
      used[e] = true;
      const Index to = next[e].second, place = placeInWalk[to];
      if (place == kNone) {
        placeInWalk[to] = Index(walk.size());
        walk.push_back(to);
        continue;
      }
      result.loops.emplace_back(walk.begin() + place, walk.end());
      for (size_t i = place + 1; i < walk.size(); ++i) placeInWalk[walk[i]] = kNone;
      walk.resize(place + 1);
    }
    result.strays += walk.size() - 1;
    for (Index i : walk) placeInWalk[i] = kNone;
  }
  return result;
}

double edgeLength(const std::vector<Vec3s>& points, Index a, Index b) {
  return (position(points, b) - position(points, a)).length();
}

double loopLength(const std::vector<Vec3s>& points, const Loop& loop) {
  double length = 0;
  for (size_t i = 0; i < loop.size(); ++i) {
    length += edgeLength(points, loop[i], loop[(i + 1) % loop.size()]);
  }
  return length;
}

/// Lengths of the connected parts of the boundary, whatever the winding: for surfaces that have no loops to
/// fill.
std::vector<double> boundaryParts(const Mesh& mesh) {
  const Edges edges = collectEdges(mesh.triangles);
  Sets parts(mesh.points.size());
  std::vector<double> lengths(mesh.points.size(), 0.0);
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) == 1) parts.join(edges.half(e, 0).low, edges.half(e, 0).high, false);
  }
  for (size_t e = 0; e < edges.count(); ++e) {
    const HalfEdge& h = edges.half(e, 0);
    if (edges.faces(e) == 1) lengths[parts.root(h.low)] += edgeLength(mesh.points, h.low, h.high);
  }
  lengths.erase(std::remove(lengths.begin(), lengths.end(), 0.0), lengths.end());
  return lengths;
}

/// Barequet & Sharir 1995: the triangulation of a closed polygon in space that has the least area.
std::vector<Vec3I> fillLeastArea(const std::vector<Vec3s>& points, const Loop& loop) {
  const size_t n = loop.size();
  std::vector<double> cost(n * n, 0.0);
  std::vector<Index> split(n * n, 0);
  for (size_t span = 2; span < n; ++span) {
    for (size_t i = 0; i + span < n; ++i) {
      const size_t j = i + span;
      const Vec3d a = position(points, loop[i]), b = position(points, loop[j]);
      double best = std::numeric_limits<double>::infinity();
      for (size_t k = i + 1; k < j; ++k) {
        const Vec3d c = position(points, loop[k]);
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

void fillHole(Mesh& mesh, const Loop& loop) {
  if (loop.size() <= kLargestLeastArea) {
    for (const Vec3I& t : fillLeastArea(mesh.points, loop)) mesh.triangles.push_back(t);
    return;
  }
  Vec3d centre(0.0);
  for (Index i : loop) centre += position(mesh.points, i);
  const Index middle = Index(mesh.points.size());
  mesh.points.emplace_back(Vec3s(centre / double(loop.size())));
  for (size_t i = 0; i < loop.size(); ++i) {
    mesh.triangles.emplace_back(loop[i], loop[(i + 1) % loop.size()], middle);
  }
}

// ---------------------------------------------------------------- inside and outside

struct Part {
  std::vector<Index> triangles;
  openvdb::BBoxd box;
  double volume = 0;
  bool closed = true;
};

std::vector<Part> partsOf(const Mesh& mesh, const Winding& winding) {
  std::vector<Index> partOf(mesh.triangles.size(), kNone);
  std::vector<Part> parts;
  const Vec3d origin = position(mesh.points, mesh.triangles[0][0]);
  for (size_t t = 0; t < mesh.triangles.size(); ++t) {
    Index& part = partOf[winding.patch[t]];
    if (part == kNone) {
      part = Index(parts.size());
      parts.emplace_back();
    }
    parts[part].triangles.push_back(Index(t));
    parts[part].volume += signedVolume(mesh.points, mesh.triangles[t], origin);
    for (int k = 0; k < 3; ++k) parts[part].box.expand(position(mesh.points, mesh.triangles[t][k]));
  }
  const Edges edges = collectEdges(mesh.triangles);
  for (size_t e = 0; e < edges.count(); ++e) {
    if (edges.faces(e) == 2) continue;
    // Patches meet here: one is closed by itself where it has two of the faces, in opposite directions.
    for (size_t i = 0; i < edges.faces(e); ++i) {
      const Index own = partOf[winding.patch[edges.half(e, i).triangle]];
      int balance = 0;
      for (size_t j = 0; j < edges.faces(e); ++j) {
        if (partOf[winding.patch[edges.half(e, j).triangle]] == own)
          balance += edges.half(e, j).forward ? 1 : -1;
      }
      if (balance != 0) parts[own].closed = false;
    }
  }
  return parts;
}

/// Winding number of a closed part about a point, by solid angles (Van Oosterom & Strackee 1983).
double windingNumber(const Mesh& mesh, const Part& part, const Vec3d& point) {
  double sum = 0;
  for (Index t : part.triangles) {
    const Vec3d a = position(mesh.points, mesh.triangles[t][0]) - point;
    const Vec3d b = position(mesh.points, mesh.triangles[t][1]) - point;
    const Vec3d c = position(mesh.points, mesh.triangles[t][2]) - point;
    const double la = a.length(), lb = b.length(), lc = c.length();
    sum += std::atan2(a.dot(b.cross(c)), la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb);
  }
  return sum / (2 * M_PI);
}

struct Turned {
  size_t insideOut = 0, cavities = 0;
};

/// A closed part is a cavity where it lies inside a part of the opposite sense; any other is turned outwards.
/// `triangles` outside closed parts keep their winding: they have no inside of their own.
Turned turnOutwards(Mesh& mesh, const std::vector<Part>& parts) {
  Turned result;
  for (const Part& part : parts) {
    if (!part.closed || part.volume == 0) continue;
    const Vec3d probe = position(mesh.points, mesh.triangles[part.triangles[0]][0]);
    bool cavity = false;
    for (const Part& other : parts) {
      const bool candidate = other.closed && (other.volume < 0) != (part.volume < 0) &&
                             std::abs(other.volume) > std::abs(part.volume) && other.box.isInside(part.box);
      if (candidate && std::abs(windingNumber(mesh, other, probe)) > 0.5) {
        cavity = true;
        break;
      }
    }
    result.cavities += cavity;
    if (part.volume > 0) continue;
    result.insideOut += !cavity;
    for (Index t : part.triangles) std::swap(mesh.triangles[t][1], mesh.triangles[t][2]);
  }
  return result;
}

// ---------------------------------------------------------------- the whole

struct Cleaned {
  Mesh mesh;
  Winding winding;
  Boundary boundary;
  Welded welded;
  Triangulated faces;
  MeshTopology found;
};

double diagonalOf(const std::vector<Vec3s>& points) {
  openvdb::BBoxd box;
  for (const Vec3s& p : points) box.expand(Vec3d(p));
  return points.empty() ? 0 : box.extents().length();
}

Cleaned clean(const PolygonMesh& input) {
  Cleaned c;
  c.welded = weld(input);
  c.faces = triangulate(input, c.welded);
  c.mesh.points = std::move(c.welded.points);
  c.mesh.triangles = std::move(c.faces.triangles);
  MeshTopology& found = c.found;
  found.weldedPoints = c.welded.merged;
  found.unusedPoints = c.welded.unused;
  found.diagonal = diagonalOf(c.mesh.points);
  for (const Vec3I& t : c.mesh.triangles) {
    found.signedVolume += signedVolume(c.mesh.points, t, position(c.mesh.points, c.mesh.triangles[0][0]));
  }
  c.winding = agreeOnWinding(c.mesh.triangles);
  c.boundary = findBoundary(c.mesh.triangles, c.mesh.points.size());
  found.shells = c.winding.shells;
  found.nonManifoldEdges = c.winding.nonManifold;
  found.twistedEdges = c.winding.twisted;
  found.boundaryEdges = c.boundary.edges;
  std::vector<double> lengths;
  for (const Loop& loop : c.boundary.loops) lengths.push_back(loopLength(c.mesh.points, loop));
  if (c.boundary.strays > 0) lengths = boundaryParts(c.mesh);
  found.boundaryLoops = lengths.size();
  for (double length : lengths) found.longestLoop = std::max(found.longestLoop, length);
  return c;
}

bool tooLarge(const Cleaned& c) {
  return c.boundary.strays > 0 || c.found.longestLoop > kLargestHole * c.found.diagonal;
}

void refuseUnusable(const Cleaned& c) {
  if (c.mesh.triangles.empty()) throw GeometryError("the mesh has no faces; a closed surface is needed");
  const MeshTopology& f = c.found;
  if (f.twistedEdges == 0 && !tooLarge(c)) return;
  std::ostringstream why;
  why << (f.twistedEdges > 0 ? "the surface is not orientable" : "the surface is open") << ": "
      << plural(f.boundaryEdges, "boundary edge") << " in " << plural(f.boundaryLoops, "loop");
  if (f.boundaryLoops > 0) {
    why << ", the longest " << number(f.longestLoop) << " long (" << number(f.longestLoop / f.diagonal)
        << " of the bounding box's diagonal of " << number(f.diagonal) << ")";
  }
  why << ", " << plural(f.nonManifoldEdges, "edge") << " with more than two faces, "
      << plural(f.twistedEdges, "edge") << " where no winding agrees, " << plural(f.shells, "shell")
      << "; needed is a closed surface that has an inside: holes up to " << kLargestHole
      << " of the diagonal are filled, larger ones must be closed first";
  throw GeometryError(why.str());
}

void noteCleaning(const Cleaned& c, Notes& notes) {
  if (c.faces.polygons) notes.push_back("triangulated " + plural(c.faces.polygons, "polygon"));
  if (c.welded.merged) notes.push_back("welded " + plural(c.welded.merged, "duplicate point"));
  if (c.welded.unused) notes.push_back("dropped " + plural(c.welded.unused, "point") + " that no face uses");
  if (c.faces.degenerate) notes.push_back("dropped " + plural(c.faces.degenerate, "degenerate face"));
  if (c.faces.duplicate) notes.push_back("dropped " + plural(c.faces.duplicate, "duplicate face"));
  if (c.winding.turned) {
    notes.push_back("turned " + plural(c.winding.turned, "face") + " wound against the neighbours");
  }
  if (c.winding.nonManifold) {
    notes.push_back(plural(c.winding.nonManifold, "edge") +
                    " with more than two faces: kept, the inside is what " +
                    "cannot be reached from outside");
  }
}

void noteTurned(const Turned& turned, Notes& notes) {
  if (turned.insideOut) {
    notes.push_back("turned " + plural(turned.insideOut, "inside-out shell") + " outwards");
  }
  if (turned.cavities) {
    notes.push_back(turned.cavities == 1 ? "1 shell is a cavity inside another: filled as solid"
                                         : std::to_string(turned.cavities) +
                                               " shells are cavities inside others: filled as solid");
  }
}

}  // namespace

RepairedMesh repairMesh(const PolygonMesh& input) {
  Cleaned c = clean(input);
  refuseUnusable(c);
  RepairedMesh result;
  noteCleaning(c, result.notes);
  for (const Loop& loop : c.boundary.loops) fillHole(c.mesh, loop);
  if (!c.boundary.loops.empty()) {
    result.notes.push_back("filled " + plural(c.boundary.loops.size(), "hole") + " (" +
                           plural(c.boundary.edges, "edge") + ")");
  }
  const Winding winding = agreeOnWinding(c.mesh.triangles);
  noteTurned(turnOutwards(c.mesh, partsOf(c.mesh, winding)), result.notes);
  result.mesh = std::move(c.mesh);
  result.found = c.found;
  return result;
}

MeshTopology inspectMesh(const PolygonMesh& mesh) { return clean(mesh).found; }

}  // namespace slicemorph
