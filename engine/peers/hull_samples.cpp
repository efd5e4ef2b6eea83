#include "engine/peers/contour_average.h"

#include <algorithm>
#include <cmath>
#include <numeric>

namespace slicemorph {
namespace {

double crossOf(const Vec2d& a, const Vec2d& b) { return a[0] * b[1] - a[1] * b[0]; }

/// Indices of the corners of the convex hull of points, anticlockwise (monotone chains).
std::vector<size_t> hullOf(const std::vector<Vec2d>& points) {
  std::vector<size_t> order(points.size());
  std::iota(order.begin(), order.end(), size_t(0));
  std::sort(order.begin(), order.end(), [&](size_t a, size_t b) {
    const Vec2d &p = points[a], &q = points[b];
    if (p[0] != q[0]) return p[0] < q[0];
    return p[1] != q[1] ? p[1] < q[1] : a < b;
  });
  std::vector<size_t> hull;
  for (int chain = 0; chain < 2; ++chain) {
    const size_t start = hull.size();
    for (const size_t i : order) {
      while (hull.size() >= start + 2 && crossOf(points[hull.back()] - points[hull[hull.size() - 2]],
                                                 points[i] - points[hull.back()]) <= 0)
        hull.pop_back();
      hull.push_back(i);
    }
    hull.pop_back();
    std::reverse(order.begin(), order.end());
  }
  return hull;
}

/// The point of the contour at a share of the way from corner `from` to corner `to` of its hull, by length.
Vec2d alongBay(const std::vector<Vec2d>& contour, size_t from, size_t to, double share) {
  const size_t n = contour.size();
  double length = 0;
  for (size_t i = from; i != to; i = (i + 1) % n) length += (contour[(i + 1) % n] - contour[i]).length();
  double left = share * length;
  for (size_t i = from; i != to; i = (i + 1) % n) {
    const Vec2d step = contour[(i + 1) % n] - contour[i];
    if (left <= step.length()) return contour[i] + step * (left / std::max(step.length(), 1e-300));
    left -= step.length();
  }
  return contour[to];
}

}  // namespace

std::vector<Vec2d> hullSamples(const std::vector<Vec2d>& given, int count) {
  std::vector<Vec2d> contour = given;
  double area = 0;
  for (size_t i = 0; i < contour.size(); ++i) area += crossOf(contour[i], contour[(i + 1) % contour.size()]);
  if (area < 0) std::reverse(contour.begin(), contour.end());
  const std::vector<size_t> hull = hullOf(contour);

  Contour ring;
  for (const size_t i : hull) ring.points.push_back(contour[i]);
  Vec2d centre(0.0);
  double weight = 0;
  for (size_t i = 0; i < ring.points.size(); ++i) {
    const Vec2d a = ring.points[i] - ring.points[0],
                b = ring.points[(i + 1) % ring.points.size()] - ring.points[0];
    centre += crossOf(a, b) * (a + b) / 3.0, weight += crossOf(a, b);
  }
  centre = ring.points[0] + centre / std::max(weight, 1e-300);

  // The hull's corners are passed in the order of their directions, once around.
  std::vector<Vec2d> samples;
  for (int s = 0; s < count; ++s) {
    const double angle = 2 * openvdb::math::pi<double>() * s / count;
    const Vec2d direction(std::cos(angle), std::sin(angle));
    for (size_t i = 0; i < hull.size(); ++i) {
      const Vec2d a = contour[hull[i]] - centre, b = contour[hull[(i + 1) % hull.size()]] - centre;
      const double left = crossOf(a, direction), right = crossOf(direction, b);
      if (left < 0 || right <= 0) continue;
      samples.push_back(alongBay(contour, hull[i], hull[(i + 1) % hull.size()], left / (left + right)));
      break;
    }
    if (samples.size() <= size_t(s)) samples.push_back(contour[hull[0]]);
  }
  return samples;
}

}  // namespace slicemorph
