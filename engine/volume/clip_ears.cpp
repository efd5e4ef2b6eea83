#include "engine/volume/clip_ears.h"

#include <cmath>
#include <limits>
#include <numeric>

namespace slicemorph {

namespace {

using openvdb::Vec2d;
using openvdb::Vec3I;
using openvdb::Vec3s;
using Index = std::uint32_t;

/// The polygon's coordinates in the plane of its Newell normal, wound counter-clockwise.
std::vector<Vec2d> flatten(const std::vector<Vec3s>& points, const std::vector<Index>& face) {
  Vec3d normal(0.0);
  const Vec3d origin = Vec3d(points[face[0]]);
  for (size_t i = 1; i + 1 < face.size(); ++i) {
    normal += (Vec3d(points[face[i]]) - origin).cross(Vec3d(points[face[i + 1]]) - origin);
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
    const Vec3d p = Vec3d(points[i]) - origin;
    flat.emplace_back(p.dot(e1), p.dot(e2));
  }
  return flat;
}

double turn(const Vec2d& a, const Vec2d& b, const Vec2d& c) {
  return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
}

/// The corner of `ring` (indices into the face) to cut off next: of the ears, the one with the largest area
/// relative to the squared lengths of its sides.
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
    // A self-intersecting or flat polygon may have no ear; the best other corner then ends the loop.
    const double score = ear ? quality : quality - 10;
    if (score > bestScore) {
      bestScore = score;
      best = i;
    }
  }
  return best;
}

}  // namespace

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

}  // namespace slicemorph
