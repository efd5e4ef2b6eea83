#include "io/structures/plane_outlines.h"

#include "engine/contours/contours.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

using Points = std::vector<Vec2d>;

/// The values with one more pixel on each side, whose values mirror those at the border as outside.
SliceImage framed(const ImagePlane& plane, const std::vector<float>& values) {
  const int w = plane.size[0], h = plane.size[1];
  SliceImage image;
  image.reserve(size_t(w + 2) * size_t(h + 2));
  for (int y = -1; y <= h; ++y)
    for (int x = -1; x <= w; ++x) {
      const int i = std::clamp(x, 0, w - 1), j = std::clamp(y, 0, h - 1);
      const float v = values[size_t(j) * size_t(w) + size_t(i)];
      image.push_back(i == x && j == y ? v : std::abs(v));
    }
  return image;
}

/// Leaves out points on the straight line between their neighbours.
Points withoutStraight(const Points& points) {
  constexpr double kStraight = 1e-9;  // pixels squared
  Points kept;
  for (size_t i = 0, n = points.size(); i < n; ++i) {
    const Vec2d &before = kept.empty() ? points[n - 1] : kept.back(), &at = points[i],
                &after = points[(i + 1) % n];
    const Vec2d a = at - before, b = after - at;
    if (std::abs(a[0] * b[1] - a[1] * b[0]) > kStraight || a.dot(b) < 0) kept.push_back(at);
  }
  return kept;
}

/// The nearest pair of points of two outlines.
struct Bridge {
  double length = std::numeric_limits<double>::infinity();
  size_t from = 0, to = 0;
};

Bridge nearestPair(const Points& from, const Points& to) {
  Bridge best;
  for (size_t i = 0; i < from.size(); ++i)
    for (size_t j = 0; j < to.size(); ++j) {
      const double length = (from[i] - to[j]).lengthSqr();
      if (length < best.length) best = {length, i, j};
    }
  return best;
}

/// The outline with its holes, the nearest first. A hole's nearest point to what is
/// joined already is kept from round to round.
Points withHoles(Points outline, std::vector<Points> holes) {
  std::vector<Bridge> bridges;
  for (const Points& hole : holes) bridges.push_back(nearestPair(outline, hole));
  while (!holes.empty()) {
    const size_t h =
        size_t(std::min_element(bridges.begin(), bridges.end(),
                                [](const Bridge& a, const Bridge& b) { return a.length < b.length; }) -
               bridges.begin());
    const Bridge bridge = bridges[h];
    Points cut(holes[h].begin() + long(bridge.to), holes[h].end());
    cut.insert(cut.end(), holes[h].begin(), holes[h].begin() + long(bridge.to) + 1);
    cut.push_back(outline[bridge.from]);
    outline.insert(outline.begin() + long(bridge.from) + 1, cut.begin(), cut.end());
    holes.erase(holes.begin() + long(h)), bridges.erase(bridges.begin() + long(h));
    for (size_t other = 0; other < holes.size(); ++other) {
      Bridge& kept = bridges[other];
      if (kept.from > bridge.from) kept.from += cut.size();
      Bridge toCut = nearestPair(cut, holes[other]);
      toCut.from += bridge.from + 1;
      if (toCut.length < kept.length) kept = toCut;
    }
  }
  return outline;
}

}  // namespace

std::vector<std::vector<Vec3d>> outlinesOn(const ImagePlane& plane, const std::vector<float>& values) {
  SlicePlanes pixels;
  pixels.origin = Vec2d(-1, -1), pixels.pixel = 1;
  pixels.nx = plane.size[0] + 2, pixels.ny = plane.size[1] + 2;
  const std::vector<Contour> contours = traceContours(framed(plane, values), pixels, 0);
  std::vector<std::vector<Vec3d>> outlines;
  for (size_t c = 0; c < contours.size(); ++c) {
    if (contours[c].hole()) continue;
    std::vector<Points> holes;
    for (const Contour& hole : contours)
      if (hole.hole() && hole.parent == int(c)) holes.push_back(withoutStraight(hole.points));
    const Points whole = withHoles(withoutStraight(contours[c].points), std::move(holes));
    outlines.emplace_back();
    for (const Vec2d& p : whole) outlines.back().push_back(plane.at(p[0], p[1]));
  }
  return outlines;
}

}  // namespace slicemorph
