#include "engine/contours/contours.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace slicemorph {

namespace {

/// Marching squares table. Index: bit i is set if corner i is inside, counted anticlockwise from the lower
/// left one. Value: pairs of edges (0 bottom, 1 right, 2 top, 3 left) from which and to which a contour
/// crosses the cell; two pairs where opposite corners are inside.
constexpr int kNoEdge = -1;
constexpr int kLinks[16][4] = {{kNoEdge},       {0, 3, kNoEdge}, {1, 0, kNoEdge}, {1, 3, kNoEdge},
                               {2, 1, kNoEdge}, {0, 3, 2, 1},    {2, 0, kNoEdge}, {2, 3, kNoEdge},
                               {3, 2, kNoEdge}, {0, 2, kNoEdge}, {1, 0, 3, 2},    {1, 2, kNoEdge},
                               {3, 1, kNoEdge}, {0, 1, kNoEdge}, {3, 0, kNoEdge}, {kNoEdge}};
/// The two ambiguous cases where the cell's centre is inside, so that the opposite inner
/// corners are connected.
constexpr int kJoined5[4] = {0, 1, 2, 3}, kJoined10[4] = {3, 0, 1, 2};

/// Links the crossings of grid edges to contours, cell by cell.
struct Tracer {
  const SliceImage& image;
  const SlicePlanes& planes;
  // Edges: 2 * pixel + 0 to the right neighbour, + 1 to the upper one. `next`: the edge that follows along
  // the contour.
  std::unordered_map<int, int> next;

  float value(int x, int y) const { return image[size_t(y) * planes.nx + x]; }

  Vec2d crossing(int edge) const {
    const int pixel = edge / 2, x = pixel % planes.nx, y = pixel / planes.nx;
    const float a = value(x, y), b = edge & 1 ? value(x, y + 1) : value(x + 1, y);
    // Keep crossings away from the corners: coinciding points would give edges of zero length.
    const double t = std::min(std::max(double(a) / (double(a) - b), 1e-3), 1 - 1e-3);
    const Vec2d p = planes.origin + planes.pixel * Vec2d(x, y);
    return p + planes.pixel * t * (edge & 1 ? Vec2d(0, 1) : Vec2d(1, 0));
  }

  /// Links the edges of one cell so that the inside (negative) lies to the left.
  void linkCell(int x, int y) {
    const int w = planes.nx, pixel = y * w + x;
    const int bottom = 2 * pixel, right = 2 * (pixel + 1) + 1, top = 2 * (pixel + w), left = 2 * pixel + 1;
    const float v[4] = {value(x, y), value(x + 1, y), value(x + 1, y + 1), value(x, y + 1)};
    int inside = 0;
    for (int i = 0; i < 4; ++i) inside |= (v[i] < 0) << i;
    const bool centre = v[0] + v[1] + v[2] + v[3] < 0;
    const int edge[4] = {bottom, right, top, left};
    const int* links = kLinks[inside];
    if (centre && inside == 5) links = kJoined5;
    if (centre && inside == 10) links = kJoined10;
    for (int i = 0; i < 4 && links[i] != kNoEdge; i += 2) next[edge[links[i]]] = edge[links[i + 1]];
  }
};

void measure(Contour& c) {
  double area = 0;
  Vec2d moment(0.0);
  for (size_t i = 0, n = c.points.size(); i < n; ++i) {
    const Vec2d &a = c.points[i], &b = c.points[(i + 1) % n];
    const double cross = a[0] * b[1] - a[1] * b[0];
    area += 0.5 * cross, moment += cross / 6 * (a + b);
  }
  c.area = area;
  c.centroid = std::abs(area) > 0 ? moment / area : c.points[0];
}

/// Sets each contour's parent, the smallest contour around it.
void nest(std::vector<Contour>& contours) {
  for (size_t i = 0; i < contours.size(); ++i)
    for (size_t j = 0; j < contours.size(); ++j) {
      const int parent = contours[i].parent;
      if (j != i && std::abs(contours[j].area) > std::abs(contours[i].area) &&
          (parent < 0 || std::abs(contours[j].area) < std::abs(contours[size_t(parent)].area)) &&
          contains(contours[j].points, contours[i].points[0]))
        contours[i].parent = int(j);
    }
}

}  // namespace

std::vector<Contour> traceContours(const SliceImage& image, const SlicePlanes& planes, double least) {
  Tracer tracer{image, planes, {}};
  std::vector<int> starts;
  for (int y = 0; y + 1 < planes.ny; ++y)
    for (int x = 0; x + 1 < planes.nx; ++x) tracer.linkCell(x, y);
  for (const auto& link : tracer.next) starts.push_back(link.first);
  std::sort(starts.begin(), starts.end());
  std::vector<Contour> contours;
  for (int start : starts) {
    Contour contour;
    int edge = start;
    for (auto it = tracer.next.find(edge); it != tracer.next.end(); it = tracer.next.find(edge)) {
      contour.points.push_back(tracer.crossing(edge));
      const int following = it->second;
      tracer.next.erase(it);
      edge = following;
    }
    if (edge != start || contour.points.size() < 3)
      continue;  // already part of another contour, or cut by the image's border
    measure(contour);
    if (std::abs(contour.area) >= least * planes.pixel * planes.pixel) contours.push_back(std::move(contour));
  }
  nest(contours);
  return contours;
}

SliceMoments momentsOf(const std::vector<Contour>& contours) {
  SliceMoments m;
  double x = 0, y = 0, xx = 0, xy = 0, yy = 0;
  for (const Contour& c : contours)
    for (size_t i = 0, n = c.points.size(); i < n; ++i) {
      const Vec2d &a = c.points[i], &b = c.points[(i + 1) % n];
      const double k = a[0] * b[1] - a[1] * b[0];
      m.area += k / 2;
      x += k * (a[0] + b[0]) / 6, y += k * (a[1] + b[1]) / 6;
      xx += k * (a[0] * a[0] + a[0] * b[0] + b[0] * b[0]) / 12;
      yy += k * (a[1] * a[1] + a[1] * b[1] + b[1] * b[1]) / 12;
      xy += k * (2 * a[0] * a[1] + a[0] * b[1] + b[0] * a[1] + 2 * b[0] * b[1]) / 24;
    }
  if (!(m.area > 0)) return {};
  m.mean = Vec2d(x, y) / m.area;
  m.xx = std::max(xx / m.area - m.mean[0] * m.mean[0], 0.0);
  m.yy = std::max(yy / m.area - m.mean[1] * m.mean[1], 0.0);
  m.xy = xy / m.area - m.mean[0] * m.mean[1];
  return m;
}

std::vector<Vec2d> resample(const Contour& contour, int count) {
  const size_t n = contour.points.size();
  std::vector<double> length(n + 1, 0);
  for (size_t i = 0; i < n; ++i)
    length[i + 1] = length[i] + (contour.points[(i + 1) % n] - contour.points[i]).length();
  std::vector<Vec2d> result;
  size_t i = 0;
  for (int k = 0; k < count; ++k) {
    const double target = length[n] * k / count;
    while (i + 1 < n && length[i + 1] <= target) ++i;
    const double t = (target - length[i]) / std::max(length[i + 1] - length[i], 1e-30);
    result.push_back(contour.points[i] + t * (contour.points[(i + 1) % n] - contour.points[i]));
  }
  return result;
}

bool contains(const std::vector<Vec2d>& polygon, const Vec2d& p) {
  bool inside = false;
  for (size_t i = 0, n = polygon.size(), j = n - 1; i < n; j = i++) {
    const Vec2d &a = polygon[i], &b = polygon[j];
    if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
      inside = !inside;
  }
  return inside;
}

}  // namespace slicemorph
