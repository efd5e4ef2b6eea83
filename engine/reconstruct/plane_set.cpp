#include "engine/reconstruct/plane_set.h"

#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <limits>

namespace slicemorph {

namespace {

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kParallel = 0.99;  // cosine: 8 degrees
// Cosine: planes closer to perpendicular than this do not meet along each other's normal.
constexpr double kLeastSlant = 1e-3;
/// Points of different planes closer than this share of the extent are the same.
constexpr double kSamePoint = 1e-7;
constexpr size_t kProbes = 4000;  // contour points that are sampled to find the gap

double median(std::vector<double>& values) {
  if (values.empty()) return 0;
  auto middle = values.begin() + long(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

double extentOf(const ContourSet& set) {
  openvdb::BBoxd box;
  for (const PlaneContours& plane : set.planes)
    for (const auto& loop : plane.loops)
      for (const Vec2d& p : loop) box.expand(plane.toWorld(p));
  return box.empty() ? 0 : box.extents()[int(box.maxExtent())];
}

std::vector<PlaneSection::Edge> shortened(const std::vector<PlaneSection::Edge>& edges, double longest) {
  std::vector<PlaneSection::Edge> out;
  for (const PlaneSection::Edge& e : edges) {
    const int parts = std::max(1, int(std::ceil((e.b - e.a).length() / longest)));
    for (int k = 0; k < parts; ++k)
      out.push_back({e.a + double(k) / parts * (e.b - e.a), e.a + double(k + 1) / parts * (e.b - e.a)});
  }
  return out;
}

double gapOf(const PlaneSet& planes) {
  size_t count = 0, seen = 0;
  for (const PlaneSection& s : planes.sections) count += s.edges.size();
  const size_t stride = std::max<size_t>(1, count / kProbes);
  std::vector<double> gaps;
  for (int i = 0; i < int(planes.sections.size()); ++i)
    for (const PlaneSection::Edge& e : planes.sections[i].edges) {
      if (seen++ % stride) continue;
      for (int side : {-1, 1}) {
        const double next = planes.nextPlane(i, planes.world(i, e.a), side).distance;
        if (next < kInfinite) gaps.push_back(next);
      }
    }
  return median(gaps);
}

void findOutermost(PlaneSet& planes) {
  planes.outermost.assign(planes.sections.size() * 2, 1);
  const double slack = 0.25 * planes.gap;
  for (size_t i = 0; i < planes.sections.size(); ++i)
    for (const PlaneSection& s : planes.sections)
      for (const PlaneSection::Edge& e : s.edges) {
        const double height = planes.sections[i].frame.height(s.frame.toWorld(e.a));
        if (height > slack) planes.outermost[2 * i + 1] = 0;
        if (height < -slack) planes.outermost[2 * i] = 0;
      }
}

/// The distance to another plane along the normal is linear over a plane, so what holds at the image's
/// corners holds everywhere in between.
void findBridged(PlaneSet& planes) {
  planes.bridged.assign(planes.sections.size() * 2, 0);
  const double most = planes.bridgedGaps * planes.gap;
  tbb::parallel_for(size_t(0), planes.sections.size(), [&](size_t i) {
    const PlaneImage& image = planes.images[i];
    if (image.distance.empty()) return;
    for (int side : {-1, 1})
      for (size_t j = 0; j < planes.sections.size() && !planes.bridged[2 * i + (side > 0)]; ++j) {
        bool next = j != i;
        for (int corner = 0; corner < 4 && next; ++corner) {
          const Vec2d q = image.position(corner & 1 ? image.width - 1 : 0, corner & 2 ? image.height - 1 : 0);
          const double t = planes.crossing(int(i), int(j), planes.world(int(i), q), side);
          next = t > 0 && t <= most;
        }
        planes.bridged[2 * i + (side > 0)] = next;
      }
  });
}

std::string millimetres(double v) {
  char text[32];
  std::snprintf(text, sizeof text, "%.4g mm", v);
  return text;
}

/// Notes gaps other than the usual one, next to contours, in a stack of parallel planes.
void noteGaps(const PlaneSet& planes, Notes& notes) {
  constexpr double kStack = 1 - 1e-6, kUneven = 0.1;  // cosine; share of the gap
  constexpr int kNamed = 5;                           // gaps that a note lists
  const Vec3d normal = planes.sections[0].frame.normal;
  std::vector<std::pair<double, bool>> heights;  // and whether there are contours
  for (const PlaneSection& s : planes.sections) {
    if (std::abs(s.frame.normal.dot(normal)) < kStack) return;
    heights.emplace_back(s.frame.origin.dot(normal), !s.edges.empty());
  }
  std::sort(heights.begin(), heights.end());
  struct Kind {
    const char* code;
    Severity severity;
    const char* what;
    int count = 0, missing = 0;
    std::string where = {};
  } kinds[3] = {{"contours.gaps-bridged", Severity::kNote, "bridged"},
                {"contours.gaps-left-open", Severity::kWarning,
                 "too wide to bridge, the object is closed on both sides"},
                {"contours.gaps-uneven", Severity::kNote, "uneven"}};
  for (size_t i = 1; i < heights.size(); ++i) {
    const double low = heights[i - 1].first, high = heights[i].first, gaps = (high - low) / planes.gap;
    if (gaps < 1e-3 || (!heights[i - 1].second && !heights[i].second) || std::abs(gaps - 1) <= kUneven)
      continue;
    Kind& kind = kinds[gaps > planes.bridgedGaps ? 1 : gaps > 1.5 ? 0 : 2];
    kind.missing += int(std::round(gaps)) - 1;
    if (++kind.count <= kNamed)
      kind.where += (kind.count > 1 ? ", " : "") + millimetres(high - low) + " from " + millimetres(low) +
                    " to " + millimetres(high);
  }
  for (const Kind& kind : kinds) {
    if (kind.count == 0) continue;
    std::string note = std::to_string(kind.count) + " gaps between planes " + kind.what;
    if (kind.missing > 0) note += " (" + std::to_string(kind.missing) + " planes missing)";
    note += ", usual gap " + millimetres(planes.gap) + ": " + kind.where;
    if (kind.count > kNamed) note += " and " + std::to_string(kind.count - kNamed) + " more";
    notes.push_back({kind.code, kind.severity, "", note});
  }
}

}  // namespace

double PlaneSet::crossing(int plane, int other, const Vec3d& p, int side) const {
  const double slant = side * sections[other].frame.normal.dot(sections[plane].frame.normal);
  if (std::abs(slant) < kLeastSlant) return -1;
  const double t = -sections[other].frame.height(p) / slant;
  return t > kSamePoint * box.extents().length() ? t : -1;
}

NextPlane PlaneSet::nextPlane(int plane, const Vec3d& p, int side) const {
  NextPlane next{kInfinite, -1};
  for (int j = 0; j < int(sections.size()); ++j) {
    if (j == plane) continue;
    const double t = crossing(plane, j, p, side);
    if (t > 0 && t < next.distance) next = {t, j};
  }
  return next;
}

bool PlaneSet::endsAt(int plane, const Vec3d& p, int side) const {
  if (bridged[2 * plane + (side > 0)]) return false;
  const NextPlane next = nextPlane(plane, p, side);
  if (next.distance <= bridgedGaps * gap) return false;
  if (outermost[2 * plane + (side > 0)]) return true;
  return next.plane >= 0 &&
         std::abs(sections[next.plane].frame.normal.dot(sections[plane].frame.normal)) > kParallel;
}

double PlaneSet::capHeight(int plane, const Vec3d& p, int side) const {
  const double behind = nextPlane(plane, p, -side).distance;
  return 0.5 * (behind < kInfinite ? std::clamp(behind, 0.5 * gap, 1.5 * gap) : gap);
}

PlaneSet cleanPlanes(const ContourSet& set, Notes& notes, double bridgedGaps) {
  PlaneSet planes;
  planes.bridgedGaps = bridgedGaps;
  const double tolerance = 1e-6 * std::max(extentOf(set), 1e-30);
  int filled = 0;
  for (size_t i = 0; i < set.planes.size(); ++i) {
    const std::string plane = "plane " + std::to_string(i + 1);
    planes.sections.push_back(sectionOf(set.planes[i], tolerance, plane, notes));
    filled += !planes.sections.back().edges.empty();
    for (const PlaneSection::Edge& e : planes.sections.back().edges)
      planes.box.expand(planes.world(int(i), e.a));
  }
  if (filled == 0) throw GeometryError(set.name + ": no contour encloses anything");
  if (filled == 1) throw GeometryError(set.name + ": contours on one plane only; a body needs two or more");
  planes.gap = gapOf(planes);
  if (planes.gap <= 0) planes.gap = planes.box.extents().length() / 4;
  findOutermost(planes);
  noteGaps(planes, notes);
  return planes;
}

Sampling samplingOf(const PlaneSet& planes) {
  std::vector<double> lengths;
  for (const PlaneSection& s : planes.sections)
    for (const PlaneSection::Edge& e : s.edges) lengths.push_back((e.b - e.a).length());
  return {median(lengths), planes.gap, planes.box.extents()[int(planes.box.maxExtent())]};
}

void makeImages(PlaneSet& planes, double step) {
  planes.step = step;
  planes.images.resize(planes.sections.size());
  tbb::parallel_for(size_t(0), planes.sections.size(), [&](size_t i) {
    planes.sections[i].edges = shortened(planes.sections[i].edges, step);
    planes.images[i] = distanceImage(planes.sections[i], step, planes.gap + 6 * step);
  });
  findBridged(planes);
}

}  // namespace slicemorph
