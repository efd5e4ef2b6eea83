#include "engine/volume/winding_number.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>
#include <tbb/parallel_invoke.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numeric>

namespace slicemorph {
namespace {

using openvdb::Vec3I;
using openvdb::Vec3s;
using Index = std::uint32_t;

/// Triangles of a leaf at most: with fewer the groups take more memory than the mesh, with more a point near the
/// surface meets more triangles than it must.
constexpr size_t kLeafTriangles = 8;
/// A group is far if it is at more than twice its radius, as in [BDSLJ18].
constexpr double kFar = 2;
/// As many bits as there are levels in the deepest tree, twice.
constexpr size_t kDeepest = 128;

struct Centroid {
  Vec3s at;
  Index triangle;
};

/// Sorts centroids so that each leaf's are neighbours: halves by the longest side of their box.
void splitAmongLeaves(std::vector<Centroid>& centroids, size_t leaves, size_t firstLeaf, size_t leafCount) {
  if (leafCount == 1) return;
  const auto start = [&](size_t leaf) {
    return centroids.begin() + std::ptrdiff_t(centroids.size() * leaf / leaves);
  };
  const auto begin = start(firstLeaf), end = start(firstLeaf + leafCount),
             middle = start(firstLeaf + leafCount / 2);
  Vec3s low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
  for (auto c = begin; c != end; ++c)
    low = openvdb::math::minComponent(low, c->at), high = openvdb::math::maxComponent(high, c->at);
  const Vec3s size = high - low;
  const int axis = size[0] >= size[1] && size[0] >= size[2] ? 0 : size[1] >= size[2] ? 1 : 2;
  std::nth_element(begin, middle, end, [axis](const Centroid& a, const Centroid& b) {
    return a.at[axis] != b.at[axis] ? a.at[axis] < b.at[axis] : a.triangle < b.triangle;
  });
  const auto lower = [&] { splitAmongLeaves(centroids, leaves, firstLeaf, leafCount / 2); };
  const auto upper = [&] { splitAmongLeaves(centroids, leaves, firstLeaf + leafCount / 2, leafCount / 2); };
  if (end - begin > 16384)
    tbb::parallel_invoke(lower, upper);
  else
    lower(), upper();
}

using Moments1 = std::array<double, 6>;
using Moments2 = std::array<double, 10>;

/// The symmetric part of a (x) b.
Moments1 symmetric(const Vec3d& a, const Vec3d& b) {
  return {a[0] * b[0],
          a[1] * b[1],
          a[2] * b[2],
          (a[0] * b[1] + a[1] * b[0]) / 2,
          (a[1] * b[2] + a[2] * b[1]) / 2,
          (a[2] * b[0] + a[0] * b[2]) / 2};
}

/// The symmetric part of a (x) t, where t is symmetric.
Moments2 symmetric(const Vec3d& a, const Moments1& t) {
  const auto [xx, yy, zz, xy, yz, zx] = t;
  return {a[0] * xx,
          a[1] * yy,
          a[2] * zz,
          (a[1] * xx + 2 * a[0] * xy) / 3,
          (a[2] * xx + 2 * a[0] * zx) / 3,
          (a[0] * yy + 2 * a[1] * xy) / 3,
          (a[2] * yy + 2 * a[1] * yz) / 3,
          (a[0] * zz + 2 * a[2] * zx) / 3,
          (a[1] * zz + 2 * a[2] * yz) / 3,
          (a[0] * yz + a[1] * zx + a[2] * xy) / 3};
}

template <size_t N>
void addTo(std::array<double, N>& sum, const std::array<double, N>& part, double factor = 1) {
  for (size_t i = 0; i < N; ++i) sum[i] += factor * part[i];
}

/// A unit complex number's argument, summed over many factors without losing whole turns.
class AngleSum {
 public:
  /// Adds the argument of x + iy, from -pi to pi.
  void add(double x, double y) {
    const double re = re_ * x - im_ * y,
                 im = re_ * y + im_ * x + 0.0;  // no negative zero: half a turn counts upwards
    if (im_ >= 0 && y > 0 && im < 0) turns_ += 1;
    if (im_ < 0 && y < 0 && im >= 0) turns_ -= 1;
    re_ = re, im_ = im;
  }
  double sum() const { return std::atan2(im_, re_) + 2 * M_PI * turns_; }

 private:
  double re_ = 1, im_ = 0, turns_ = 0;
};

/// Distance along a ray at which it hits a triangle [MT97]; infinite if it does not.
double rayMeets(const Vec3d& origin, const Vec3d& direction, const Vec3d& a, const Vec3d& b, const Vec3d& c) {
  constexpr double kNever = std::numeric_limits<double>::infinity();
  const Vec3d ab = b - a, ac = c - a, p = direction.cross(ac), s = origin - a, q = s.cross(ab);
  const double det = ab.dot(p);
  if (det == 0) return kNever;
  const double u = s.dot(p) / det, v = direction.dot(q) / det, t = ac.dot(q) / det;
  return u >= 0 && v >= 0 && u + v <= 1 && t > 0 ? t : kNever;
}

std::vector<Index> allOf(const Mesh& mesh) {
  std::vector<Index> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), Index(0));
  return all;
}

}  // namespace

/// A group while it is gathered.
struct WindingNumber::Draft {
  Vec3d centre{0.0};
  double weight = 0, radius = 0;  ///< sum of the areas; reach of the triangles from the centre
  openvdb::BBoxd box;
  Vec3d area{0.0};
  Moments1 first{};
  Moments2 second{};

  void add(const Draft& part) {
    const Vec3d s = part.centre - centre;
    const Moments1 ss = symmetric(s, s);
    addTo(second, part.second);
    addTo(second, symmetric(s, part.first), 2);
    addTo(second, symmetric(part.area, ss));
    addTo(first, part.first);
    addTo(first, symmetric(part.area, s));
    area += part.area;
  }
};

WindingNumber::WindingNumber(const Mesh& mesh) : WindingNumber(mesh, allOf(mesh)) {}

WindingNumber::WindingNumber(const Mesh& mesh, std::vector<Index> triangles)
    : mesh_(mesh), order_(std::move(triangles)) {
  while (leaves_ * kLeafTriangles < order_.size()) leaves_ *= 2;
  sortIntoLeaves();
  gatherGroups();
}

void WindingNumber::sortIntoLeaves() {
  std::vector<Centroid> centroids(order_.size());
  const tbb::blocked_range<size_t> all(0, order_.size(), 4096);
  tbb::parallel_for(all, [&](const tbb::blocked_range<size_t>& part) {
    for (size_t i = part.begin(); i < part.end(); ++i) {
      const Vec3I& t = mesh_.triangles[order_[i]];
      centroids[i] = {(mesh_.points[t[0]] + mesh_.points[t[1]] + mesh_.points[t[2]]) / 3.f, order_[i]};
    }
  });
  splitAmongLeaves(centroids, leaves_, 0, leaves_);
  for (size_t i = 0; i < order_.size(); ++i) order_[i] = centroids[i].triangle;
}

WindingNumber::Draft WindingNumber::draftOfLeaf(size_t leaf) const {
  Draft draft;
  const size_t begin = firstOf(leaf), end = firstOf(leaf + 1);
  const auto corner = [&](size_t i, int k) { return Vec3d(mesh_.points[mesh_.triangles[order_[i]][k]]); };
  Vec3d weighted(0.0), plain(0.0);
  for (size_t i = begin; i < end; ++i) {
    const Vec3d a = corner(i, 0), b = corner(i, 1), c = corner(i, 2);
    const double area = (b - a).cross(c - a).length() / 2;
    draft.weight += area;
    weighted += area * (a + b + c) / 3;
    plain += (a + b + c) / 3;
  }
  if (begin < end) draft.centre = draft.weight > 0 ? weighted / draft.weight : plain / double(end - begin);
  for (size_t i = begin; i < end; ++i) {
    const Vec3d u[3] = {corner(i, 0) - draft.centre, corner(i, 1) - draft.centre,
                        corner(i, 2) - draft.centre};
    const Vec3d area = (u[1] - u[0]).cross(u[2] - u[0]) / 2, sum = u[0] + u[1] + u[2];
    Moments1 square = symmetric(sum, sum);
    for (const Vec3d& v : u) {
      addTo(square, symmetric(v, v));
      draft.radius = std::max(draft.radius, v.length());
      draft.box.expand(v + draft.centre);
    }
    draft.area += area;
    addTo(draft.first, symmetric(area, sum / 3));
    addTo(draft.second, symmetric(area, square), 1.0 / 12);
  }
  return draft;
}

WindingNumber::Draft WindingNumber::joined(const Draft& a, const Draft& b) {
  Draft both;
  both.weight = a.weight + b.weight;
  both.centre =
      both.weight > 0 ? (a.centre * a.weight + b.centre * b.weight) / both.weight : (a.centre + b.centre) / 2;
  both.box = a.box;
  both.box.expand(b.box);
  both.add(a);
  both.add(b);
  Vec3d reach;
  for (int i = 0; i < 3; ++i)
    reach[i] = std::max(both.box.max()[i] - both.centre[i], both.centre[i] - both.box.min()[i]);
  both.radius = std::min(reach.length(), std::max(a.radius + (a.centre - both.centre).length(),
                                                  b.radius + (b.centre - both.centre).length()));
  return both;
}

WindingNumber::Group WindingNumber::rounded(const Draft& draft) {
  Group group;
  for (int i = 0; i < 3; ++i) group.centre[i] = float(draft.centre[i]), group.area[i] = float(draft.area[i]);
  // Rounding up, so that rounded centres keep all triangles within.
  const double slack =
      1e-6 * (std::abs(draft.centre[0]) + std::abs(draft.centre[1]) + std::abs(draft.centre[2]));
  group.squaredRadius = float((draft.radius + slack) * (draft.radius + slack) * (1 + 1e-6));
  for (size_t i = 0; i < 6; ++i) group.first[i] = float(draft.first[i]);
  for (size_t i = 0; i < 10; ++i) group.second[i] = float(draft.second[i]);
  return group;
}

void WindingNumber::gatherGroups() {
  groups_.resize(2 * leaves_);
  // Subtrees of at most kTogether leaves are gathered by one task each, bottom up, so that few drafts live at a time.
  constexpr size_t kTogether = 1024;
  const size_t together = std::min(kTogether, leaves_), tasks = leaves_ / together;
  std::vector<Draft> tops(2 * tasks);
  const auto gather = [&](std::vector<Draft>& drafts, size_t root, size_t count) {
    // drafts[count..2 count) are the lowest level; its heap's node i at depth d is root * 2^d + (i - 2^d) of the whole.
    for (size_t i = 2 * count - 1; i > 0; --i) {
      if (i < count) drafts[i] = joined(drafts[2 * i], drafts[2 * i + 1]);
      size_t top = 1;
      while (2 * top <= i) top *= 2;
      groups_[root * top + (i - top)] = rounded(drafts[i]);
    }
  };
  tbb::parallel_for(size_t(0), tasks, [&](size_t task) {
    std::vector<Draft> drafts(2 * together);
    for (size_t i = 0; i < together; ++i) drafts[together + i] = draftOfLeaf(task * together + i);
    gather(drafts, tasks + task, together);
    tops[tasks + task] = drafts[1];
  });
  gather(tops, 1, tasks);
}

double WindingNumber::farAngle(const Group& g, const Vec3d& toCentre) const {
  const double x = toCentre[0], y = toCentre[1], z = toCentre[2];
  const double inverse2 = 1 / toCentre.lengthSqr(), inverse3 = inverse2 * std::sqrt(inverse2);
  const float *m = g.first, *s = g.second;
  const double zeroth = g.area[0] * x + g.area[1] * y + g.area[2] * z;
  const double trace = double(m[0]) + m[1] + m[2];
  const double mrr =
      m[0] * x * x + m[1] * y * y + m[2] * z * z + 2 * (m[3] * x * y + m[4] * y * z + m[5] * z * x);
  const double sr =
      (double(s[0]) + s[5] + s[7]) * x + (double(s[1]) + s[3] + s[8]) * y + (double(s[2]) + s[4] + s[6]) * z;
  const double srrr =
      s[0] * x * x * x + s[1] * y * y * y + s[2] * z * z * z +
      3 * (x * x * (s[3] * y + s[4] * z) + y * y * (s[5] * x + s[6] * z) + z * z * (s[7] * x + s[8] * y)) +
      6 * s[9] * x * y * z;
  return inverse3 * (zeroth + trace - inverse2 * (3 * mrr + 4.5 * sr - 7.5 * inverse2 * srrr));
}

double WindingNumber::nearAngle(size_t leaf, const Vec3d& point) const {
  AngleSum halves;
  for (size_t i = firstOf(leaf); i < firstOf(leaf + 1); ++i) {
    const Vec3I& t = mesh_.triangles[order_[i]];
    const Vec3d a = Vec3d(mesh_.points[t[0]]) - point, b = Vec3d(mesh_.points[t[1]]) - point,
                c = Vec3d(mesh_.points[t[2]]) - point;
    const double la = a.length(), lb = b.length(), lc = c.length();
    const double y = a.dot(b.cross(c)) + 0.0,
                 x = la * lb * lc + a.dot(b) * lc + b.dot(c) * la + c.dot(a) * lb;
    const double size = std::abs(x) + std::abs(y);
    if (size > 0) halves.add(x / size, y / size);
  }
  return 2 * halves.sum();
}

double WindingNumber::at(const Vec3d& point) const {
  double angle = 0;
  size_t stack[kDeepest], depth = 0;
  stack[depth++] = 1;
  while (depth > 0) {
    const size_t i = stack[--depth];
    const Group& group = groups_[i];
    const Vec3d toCentre = Vec3d(group.centre[0], group.centre[1], group.centre[2]) - point;
    if (toCentre.lengthSqr() > kFar * kFar * group.squaredRadius) {
      angle += farAngle(group, toCentre);
    } else if (i >= leaves_) {
      angle += nearAngle(i - leaves_, point);
    } else {
      stack[depth++] = 2 * i + 1;
      stack[depth++] = 2 * i;
    }
  }
  return angle / (4 * M_PI);
}

std::optional<Index> WindingNumber::firstHit(const Vec3d& origin, const Vec3d& direction) const {
  const Vec3d along = direction.unit();
  double nearest = std::numeric_limits<double>::infinity();
  std::optional<Index> hit;
  size_t stack[kDeepest], depth = 0;
  stack[depth++] = 1;
  while (depth > 0) {
    const size_t i = stack[--depth];
    const Group& group = groups_[i];
    const Vec3d toCentre = Vec3d(group.centre[0], group.centre[1], group.centre[2]) - origin;
    const double ahead = toCentre.dot(along), squared = toCentre.lengthSqr(),
                 beside = squared - ahead * ahead;
    if (beside > group.squaredRadius * (1 + 1e-9) + 1e-12 * squared) continue;
    const double half = std::sqrt(std::max(0.0, group.squaredRadius - beside)) * (1 + 1e-6);
    if (ahead + half < 0 || ahead - half > nearest) continue;
    if (i < leaves_) {
      stack[depth++] = 2 * i + 1;
      stack[depth++] = 2 * i;
      continue;
    }
    for (size_t k = firstOf(i - leaves_); k < firstOf(i - leaves_ + 1); ++k) {
      const Vec3I& t = mesh_.triangles[order_[k]];
      const double distance = rayMeets(origin, along, Vec3d(mesh_.points[t[0]]), Vec3d(mesh_.points[t[1]]),
                                       Vec3d(mesh_.points[t[2]]));
      if (distance < nearest) nearest = distance, hit = order_[k];
    }
  }
  return hit;
}

}  // namespace slicemorph
