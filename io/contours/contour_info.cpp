#include "io/contours/contour_info.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

constexpr double kParallelNormals = 1 - 1e-6;  // cosine: 0.08 degrees

double loopArea(const std::vector<Vec2d>& loop) {
  double area = 0;
  for (size_t i = 0, n = loop.size(); i < n; ++i) {
    const Vec2d &a = loop[i], &b = loop[(i + 1) % n];
    area += 0.5 * (a[0] * b[1] - a[1] * b[0]);
  }
  return std::abs(area);
}

bool encloses(const std::vector<Vec2d>& loop, const Vec2d& p) {
  bool inside = false;
  for (size_t i = 0, n = loop.size(), j = n - 1; i < n; j = i++) {
    const Vec2d &a = loop[i], &b = loop[j];
    if ((a[1] > p[1]) != (b[1] > p[1]) && p[0] < a[0] + (p[1] - a[1]) / (b[1] - a[1]) * (b[0] - a[0]))
      inside = !inside;
  }
  return inside;
}

/// Area inside the loops of a plane, those within an odd number of others taken off.
double planeArea(const PlaneContours& plane) {
  double area = 0;
  for (const std::vector<Vec2d>& loop : plane.loops) {
    if (loop.empty()) continue;
    const auto around =
        std::count_if(plane.loops.begin(), plane.loops.end(), [&](const std::vector<Vec2d>& other) {
          return &other != &loop && loopArea(other) > loopArea(loop) && encloses(other, loop[0]);
        });
    area += around % 2 ? -loopArea(loop) : loopArea(loop);
  }
  return area;
}

StructureInfo describeStructure(const ContourSet& set) {
  StructureInfo info;
  info.number = set.label, info.name = set.name;
  openvdb::BBoxd box;
  std::vector<std::pair<double, double>> areas;  // by height along the first plane's normal
  bool parallel = true;
  for (const PlaneContours& plane : set.planes) {
    if (plane.loops.empty()) continue;
    ++info.planes, info.contours += plane.loops.size();
    for (const std::vector<Vec2d>& loop : plane.loops)
      for (const Vec2d& p : loop) box.expand(plane.toWorld(p));
    const Vec3d& normal = set.planes[0].normal;
    parallel = parallel && std::abs(normal.dot(plane.normal)) > kParallelNormals;
    areas.emplace_back(plane.origin.dot(normal), planeArea(plane));
  }
  if (info.planes == 0) return info;
  info.boxMin = box.min(), info.boxMax = box.max();
  if (!parallel || areas.size() < 2) return info;
  std::sort(areas.begin(), areas.end());
  std::vector<double> gaps;
  for (size_t i = 1; i < areas.size(); ++i) gaps.push_back(areas[i].first - areas[i - 1].first);
  std::vector<double> sorted = gaps;
  std::sort(sorted.begin(), sorted.end());
  info.gapMin = sorted.front(), info.gap = sorted[sorted.size() / 2], info.gapMax = sorted.back();
  info.volume = 0;
  for (size_t i = 0; i < areas.size(); ++i)
    *info.volume += areas[i].second * 0.5 *
                    ((i > 0 ? gaps[i - 1] : info.gap) + (i + 1 < areas.size() ? gaps[i] : info.gap));
  return info;
}

}  // namespace

std::vector<StructureInfo> describeStructures(const std::vector<ContourSet>& sets) {
  std::vector<StructureInfo> infos;
  for (const ContourSet& set : sets) infos.push_back(describeStructure(set));
  return infos;
}

}  // namespace slicemorph
