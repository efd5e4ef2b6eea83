#include "engine/measure/measure.h"
#include "engine/numerics/percentile.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

struct Triangle {
  Vec3s a, b, c;
};

struct Box {
  Vec3s low{std::numeric_limits<float>::max()}, high{std::numeric_limits<float>::lowest()};

  void add(const Vec3s& p) {
    for (int i = 0; i < 3; ++i) low[i] = std::min(low[i], p[i]), high[i] = std::max(high[i], p[i]);
  }
  double squaredDistance(const Vec3d& p) const {
    double sum = 0;
    for (int i = 0; i < 3; ++i) {
      const double outside = std::max({low[i] - p[i], p[i] - high[i], 0.0});
      sum += outside * outside;
    }
    return sum;
  }
};

/// What encloses some triangles: their box, and how far they reach along their mean normal. Where a surface is seen from
/// far off, as a large sphere from near its centre, boxes alone tell hardly which part of it is nearer.
struct Bounds {
  Box box;
  Vec3s normal{0.f};  ///< unit length; 0 where there is no mean
  float from = 0, to = 0;
  static constexpr double kRounded = 1 - 1e-6;  ///< the normal's length is 1 but for its rounding

  double squaredDistance(const Vec3d& p) const {
    const double along = Vec3d(normal).dot(p);
    const double outside = kRounded * std::max({double(from) - along, along - double(to), 0.0});
    return std::max(box.squaredDistance(p), outside * outside);
  }
};

double squaredDistanceToSegment(const Vec3d& p, const Vec3d& a, const Vec3d& b) {
  const Vec3d ab = b - a;
  const double length = ab.lengthSqr();
  const double t = length > 0 ? std::clamp((p - a).dot(ab) / length, 0.0, 1.0) : 0.0;
  return (p - a - t * ab).lengthSqr();
}

/// Ericson, Real-Time Collision Detection, 5.1.5: within the triangle's prism the distance to the plane, else
/// to an edge.
double squaredDistance(const Vec3d& p, const Triangle& triangle) {
  const Vec3d a(triangle.a), b(triangle.b), c(triangle.c);
  const Vec3d normal = (b - a).cross(c - a);
  const bool inAB = normal.cross(b - a).dot(p - a) >= 0, inBC = normal.cross(c - b).dot(p - b) >= 0,
             inCA = normal.cross(a - c).dot(p - c) >= 0;
  const double area = normal.lengthSqr();
  if (inAB && inBC && inCA && area > 0) {
    const double height = normal.dot(p - a);
    return height * height / area;
  }
  return std::min({squaredDistanceToSegment(p, a, b), squaredDistanceToSegment(p, b, c),
                   squaredDistanceToSegment(p, c, a)});
}

/// Balanced tree of bounds over the triangles of a mesh, split at the median along the longest side
/// of the centroids' box. Node i has the children 2 i + 1 and 2 i + 2.
class TriangleTree {
 public:
  explicit TriangleTree(const Mesh& mesh) {
    for (const auto& t : mesh.triangles)
      triangles_.push_back({mesh.points[t[0]], mesh.points[t[1]], mesh.points[t[2]]});
    size_t nodes = 1;
    for (size_t n = triangles_.size(); n > kLeafSize; n = (n + 1) / 2) nodes = 2 * nodes + 1;
    bounds_.resize(nodes);
    build(0, 0, triangles_.size());
  }

  struct Nearest {
    double squared = std::numeric_limits<double>::max();
    size_t triangle = 0;
  };
  /// The triangle closest to `p`. `guess` may be any triangle's index; a good one saves time.
  Nearest nearest(const Vec3d& p, size_t guess) const {
    Nearest best{squaredDistance(p, triangles_[guess]), guess};
    search(p, 0, 0, triangles_.size(), best);
    return best;
  }

 private:
  static constexpr size_t kLeafSize = 4;  ///< triangles of a node that is not split

  Bounds boundsOf(size_t first, size_t last) const {
    Bounds bounds;
    Vec3d normal(0.0);
    for (size_t i = first; i < last; ++i) {
      const Triangle& t = triangles_[i];
      for (const Vec3s& p : {t.a, t.b, t.c}) bounds.box.add(p);
      normal += (Vec3d(t.b) - Vec3d(t.a)).cross(Vec3d(t.c) - Vec3d(t.a));
    }
    if (!normal.normalize()) return bounds;
    bounds.normal = Vec3s(normal);
    const Vec3d rounded(bounds.normal);
    double from = std::numeric_limits<double>::max(), to = std::numeric_limits<double>::lowest();
    for (size_t i = first; i < last; ++i)
      for (const Vec3s& p : {triangles_[i].a, triangles_[i].b, triangles_[i].c}) {
        const double along = rounded.dot(Vec3d(p));
        from = std::min(from, along), to = std::max(to, along);
      }
    // Rounded outwards.
    constexpr float kInfinite = std::numeric_limits<float>::infinity();
    bounds.from = std::nextafter(float(from), -kInfinite), bounds.to = std::nextafter(float(to), kInfinite);
    return bounds;
  }

  void build(size_t node, size_t first, size_t last) {
    Box centres;
    for (size_t i = first; i < last; ++i) centres.add(triangles_[i].a + triangles_[i].b + triangles_[i].c);
    bounds_[node] = boundsOf(first, last);
    if (last - first <= kLeafSize) return;
    const Vec3s size = centres.high - centres.low;
    const size_t axis = openvdb::math::MaxIndex(size);
    const size_t middle = (first + last) / 2;
    const auto begin = triangles_.begin();
    std::nth_element(begin + first, begin + middle, begin + last,
                     [axis](const Triangle& s, const Triangle& t) {
                       return s.a[axis] + s.b[axis] + s.c[axis] < t.a[axis] + t.b[axis] + t.c[axis];
                     });
    const auto left = [&] { build(2 * node + 1, first, middle); };
    const auto right = [&] { build(2 * node + 2, middle, last); };
    if (last - first > 8192)
      tbb::parallel_invoke(left, right);
    else
      left(), right();
  }

  void search(const Vec3d& p, size_t node, size_t first, size_t last, Nearest& best) const {
    if (last - first <= kLeafSize) {
      for (size_t i = first; i < last; ++i) {
        const double squared = squaredDistance(p, triangles_[i]);
        if (squared < best.squared) best = {squared, i};
      }
      return;
    }
    const size_t middle = (first + last) / 2, left = 2 * node + 1, right = left + 1;
    const double toLeft = bounds_[left].squaredDistance(p), toRight = bounds_[right].squaredDistance(p);
    const bool leftFirst = toLeft <= toRight;
    if (leftFirst && toLeft < best.squared) search(p, left, first, middle, best);
    if (toRight < best.squared) search(p, right, middle, last, best);
    if (!leftFirst && toLeft < best.squared) search(p, left, first, middle, best);
  }

  std::vector<Triangle> triangles_;
  std::vector<Bounds> bounds_;
};

using Points = std::vector<openvdb::Vec3s>;

/// The points that triangles use.
Points usedPoints(const Mesh& mesh) {
  std::vector<char> used(mesh.points.size(), 0);
  for (const auto& t : mesh.triangles) used[t[0]] = used[t[1]] = used[t[2]] = 1;
  Points points;
  for (size_t i = 0; i < used.size(); ++i)
    if (used[i]) points.push_back(mesh.points[i]);
  return points;
}

void appendDistances(const Points& points, const Mesh& to, std::vector<double>& distances) {
  const TriangleTree tree(to);
  const size_t start = distances.size();
  distances.resize(start + points.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, points.size(), 512), [&](const auto& range) {
    size_t guess = 0;  // consecutive points are mostly close to each other
    for (size_t i = range.begin(); i != range.end(); ++i) {
      const auto nearest = tree.nearest(Vec3d(points[i]), guess);
      distances[start + i] = std::sqrt(nearest.squared);
      guess = nearest.triangle;
    }
  });
}

void requireTriangles(const Mesh& mesh) {
  if (mesh.triangles.empty())
    throw GeometryError("a surface without triangles has no distance to another one");
}

SurfaceDistance summarise(std::vector<double> distances) {
  SurfaceDistance result;
  result.mean = std::accumulate(distances.begin(), distances.end(), 0.0) / double(distances.size());
  result.p95 = percentileOf(distances, 0.95), result.p99 = percentileOf(distances, 0.99);
  result.max = *std::max_element(distances.begin(), distances.end());
  return result;
}

}  // namespace

SurfaceDistance surfaceDistance(const Mesh& a, const Mesh& b) {
  requireTriangles(a);
  requireTriangles(b);
  std::vector<double> distances;
  appendDistances(usedPoints(a), b, distances);
  appendDistances(usedPoints(b), a, distances);
  return summarise(std::move(distances));
}

SurfaceDistance distanceTo(const std::vector<openvdb::Vec3s>& points, const Mesh& mesh) {
  requireTriangles(mesh);
  if (points.empty()) throw GeometryError("no points have no distance to a surface");
  std::vector<double> distances;
  appendDistances(points, mesh, distances);
  return summarise(std::move(distances));
}

}  // namespace slicemorph
