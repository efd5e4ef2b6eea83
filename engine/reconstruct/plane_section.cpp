#include "engine/reconstruct/plane_section.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <numeric>

namespace slicemorph {

namespace {

using Edge = PlaneSection::Edge;
using Loop = std::vector<Vec2d>;

double cross(const Vec2d& a, const Vec2d& b) { return a[0] * b[1] - a[1] * b[0]; }

/// The loop without points that repeat the one before.
Loop distinct(const Loop& loop, double tolerance) {
  Loop out;
  for (const Vec2d& p : loop)
    if (out.empty() || (p - out.back()).length() > tolerance) out.push_back(p);
  while (out.size() > 1 && (out.front() - out.back()).length() <= tolerance) out.pop_back();
  return out;
}

using Key = std::array<long long, 2>;
Key keyOf(const Vec2d& p, double tolerance) {
  return {std::llround(p[0] / tolerance), std::llround(p[1] / tolerance)};
}

/// The points in sorted order: the same for a loop that starts elsewhere or has the opposite direction.
std::vector<Key> signature(const Loop& loop, double tolerance) {
  std::vector<Key> keys;
  for (const Vec2d& p : loop) keys.push_back(keyOf(p, tolerance));
  std::sort(keys.begin(), keys.end());
  return keys;
}

/// Where two edges properly intersect, as a fraction of the first; negative: they do not.
double crossing(const Edge& e, const Edge& f) {
  if (std::max(e.a[0], e.b[0]) < std::min(f.a[0], f.b[0]) ||
      std::max(f.a[0], f.b[0]) < std::min(e.a[0], e.b[0]) ||
      std::max(e.a[1], e.b[1]) < std::min(f.a[1], f.b[1]) ||
      std::max(f.a[1], f.b[1]) < std::min(e.a[1], e.b[1]))
    return -1;
  const Vec2d d = e.b - e.a, g = f.b - f.a;
  const double c1 = cross(d, f.a - e.a), c2 = cross(d, f.b - e.a), c3 = cross(g, e.a - f.a),
               c4 = cross(g, e.b - f.a);
  if ((c1 < 0) == (c2 < 0) || (c3 < 0) == (c4 < 0) || c1 == 0 || c2 == 0 || c3 == 0 || c4 == 0) return -1;
  return c3 / (c3 - c4);
}

bool inside(const std::vector<Edge>& edges, const Vec2d& p) {
  bool in = false;
  for (const Edge& e : edges)
    if ((e.a[1] > p[1]) != (e.b[1] > p[1]) &&
        p[0] < e.a[0] + (p[1] - e.a[1]) / (e.b[1] - e.a[1]) * (e.b[0] - e.a[0]))
      in = !in;
  return in;
}

/// Removes edges that occur an even number of times.
std::vector<Edge> withoutKeyholes(const std::vector<Edge>& edges, double tolerance) {
  std::map<std::array<Key, 2>, int> count;
  const auto keys = [&](const Edge& e) {
    std::array<Key, 2> k{keyOf(e.a, tolerance), keyOf(e.b, tolerance)};
    if (k[1] < k[0]) std::swap(k[0], k[1]);
    return k;
  };
  for (const Edge& e : edges) ++count[keys(e)];
  std::vector<Edge> out;
  for (const Edge& e : edges) {
    int& n = count[keys(e)];
    if (n % 2 == 1) out.push_back(e);
    n = 0;
  }
  return out;
}

struct SectionRegion {
  std::vector<Edge> edges;
  Vec2d low{0, 0}, high{0, 0};
};

SectionRegion regionOf(const Loop& loop, double tolerance) {
  SectionRegion region;
  region.low = region.high = loop[0];
  for (size_t i = 0; i < loop.size(); ++i) {
    region.edges.push_back({loop[i], loop[(i + 1) % loop.size()]});
    for (int a = 0; a < 2; ++a) {
      region.low[a] = std::min(region.low[a], loop[i][a]);
      region.high[a] = std::max(region.high[a], loop[i][a]);
    }
  }
  region.edges = withoutKeyholes(region.edges, tolerance);
  return region;
}

bool cross(const SectionRegion& a, const SectionRegion& b) {
  for (int k = 0; k < 2; ++k)
    if (a.high[k] < b.low[k] || b.high[k] < a.low[k]) return false;
  for (const Edge& e : a.edges)
    for (const Edge& f : b.edges)
      if (crossing(e, f) >= 0) return true;
  return false;
}

/// The parts of a's edges that are outside b.
std::vector<Edge> outsideOf(const SectionRegion& a, const SectionRegion& b) {
  std::vector<Edge> out;
  for (const Edge& e : a.edges) {
    std::vector<double> cuts{0, 1};
    for (const Edge& f : b.edges) {
      const double t = crossing(e, f);
      if (t >= 0) cuts.push_back(t);
    }
    std::sort(cuts.begin(), cuts.end());
    for (size_t i = 0; i + 1 < cuts.size(); ++i)
      if (cuts[i + 1] > cuts[i] && !inside(b.edges, e.a + 0.5 * (cuts[i] + cuts[i + 1]) * (e.b - e.a)))
        out.push_back({e.a + cuts[i] * (e.b - e.a), e.a + cuts[i + 1] * (e.b - e.a)});
  }
  return out;
}

SectionRegion joined(const SectionRegion& a, const SectionRegion& b) {
  SectionRegion out;
  out.edges = outsideOf(a, b);
  const std::vector<Edge> rest = outsideOf(b, a);
  out.edges.insert(out.edges.end(), rest.begin(), rest.end());
  for (int k = 0; k < 2; ++k) {
    out.low[k] = std::min(a.low[k], b.low[k]);
    out.high[k] = std::max(a.high[k], b.high[k]);
  }
  return out;
}

int selfCrossings(const SectionRegion& region) {
  int count = 0;
  for (size_t i = 0; i < region.edges.size(); ++i)
    for (size_t j = i + 1; j < region.edges.size(); ++j)
      count += crossing(region.edges[i], region.edges[j]) >= 0;
  return count;
}

double distanceTo(const Edge& e, const Vec2d& p) {
  const Vec2d d = e.b - e.a, q = p - e.a;
  const double l = d.lengthSqr();
  const double t = l > 0 ? std::clamp(q.dot(d) / l, 0.0, 1.0) : 0;
  return (q - t * d).length();
}

/// Propagates the nearest edges from pixel to pixel.
class Spread {
 public:
  Spread(const PlaneSection& section, PlaneImage& image) : section_(section), image_(image) {}

  void run() {
    seed();
    for (int j = 0; j < image_.height; ++j) sweep(j, -1);
    for (int j = image_.height - 1; j >= 0; --j) sweep(j, 1);
    for (int j = 0; j < image_.height; ++j) sweep(j, -1);
  }

 private:
  size_t index(int i, int j) const { return size_t(j) * image_.width + i; }

  void seed() {
    for (int e = 0; e < int(section_.edges.size()); ++e) {
      const Edge& edge = section_.edges[e];
      int low[2], high[2];
      for (int a = 0; a < 2; ++a) {
        const double from = std::min(edge.a[a], edge.b[a]) - image_.low[a];
        const double to = std::max(edge.a[a], edge.b[a]) - image_.low[a];
        low[a] = std::max(0, int(std::floor(from / image_.pixel)) - 1);
        high[a] = std::min((a ? image_.height : image_.width) - 1, int(std::ceil(to / image_.pixel)) + 1);
      }
      for (int j = low[1]; j <= high[1]; ++j)
        for (int i = low[0]; i <= high[0]; ++i) offer(i, j, e);
    }
  }
  void offer(int i, int j, int edge) {
    if (edge < 0) return;
    const size_t n = index(i, j);
    if (image_.nearest[n] == edge) return;
    const float d = float(distanceTo(section_.edges[edge], image_.position(i, j)));
    if (d < image_.distance[n]) image_.distance[n] = d, image_.nearest[n] = edge;
  }
  /// Takes edges from row j + `from`, then propagates along the row in both directions.
  void sweep(int j, int from) {
    const int other = j + from;
    if (other >= 0 && other < image_.height)
      for (int i = 0; i < image_.width; ++i)
        for (int di = -1; di <= 1; ++di)
          if (i + di >= 0 && i + di < image_.width) offer(i, j, image_.nearest[index(i + di, other)]);
    for (int i = 1; i < image_.width; ++i) offer(i, j, image_.nearest[index(i - 1, j)]);
    for (int i = image_.width - 2; i >= 0; --i) offer(i, j, image_.nearest[index(i + 1, j)]);
  }

  const PlaneSection& section_;
  PlaneImage& image_;
};

void setSigns(const PlaneSection& section, PlaneImage& image) {
  std::vector<double> crossings;
  for (int j = 0; j < image.height; ++j) {
    const double y = image.position(0, j)[1];
    crossings.clear();
    for (const Edge& e : section.edges)
      if ((e.a[1] > y) != (e.b[1] > y))
        crossings.push_back(e.a[0] + (y - e.a[1]) / (e.b[1] - e.a[1]) * (e.b[0] - e.a[0]));
    std::sort(crossings.begin(), crossings.end());
    size_t passed = 0;
    for (int i = 0; i < image.width; ++i) {
      const double x = image.position(i, j)[0];
      while (passed < crossings.size() && crossings[passed] < x) ++passed;
      if (passed % 2 == 1) image.distance[size_t(j) * image.width + i] *= -1;
    }
  }
}

}  // namespace

PlaneContours planeAt(const Vec3d& origin, const Vec3d& normal) {
  PlaneContours plane;
  plane.origin = origin;
  plane.normal = normal.unit();
  int least = 0;
  for (int a = 1; a < 3; ++a)
    if (std::abs(plane.normal[a]) < std::abs(plane.normal[least]) - 1e-9) least = a;
  Vec3d axis(0.0);
  axis[least] = 1;
  plane.x = (axis - axis.dot(plane.normal) * plane.normal).unit();
  plane.y = plane.normal.cross(plane.x);
  return plane;
}

PlaneSection sectionOf(const PlaneContours& plane, double tolerance, const std::string& subject,
                       Notes& notes) {
  PlaneSection section;
  section.frame = plane;
  section.frame.loops.clear();
  std::vector<SectionRegion> regions;
  std::vector<std::vector<Key>> seen;
  int twice = 0, flat = 0, crossed = 0, overlapping = 0;
  for (const Loop& given : plane.loops) {
    const Loop loop = distinct(given, tolerance);
    if (loop.size() < 3) {
      ++flat;
      continue;
    }
    std::vector<Key> keys = signature(loop, tolerance);
    if (std::find(seen.begin(), seen.end(), keys) != seen.end()) {
      ++twice;
      continue;
    }
    seen.push_back(std::move(keys));
    SectionRegion region = regionOf(loop, tolerance);
    crossed += selfCrossings(region) > 0;
    regions.push_back(std::move(region));
  }
  for (size_t i = 0; i < regions.size(); ++i)
    for (size_t j = i + 1; j < regions.size();) {
      if (!cross(regions[i], regions[j])) {
        ++j;
        continue;
      }
      regions[i] = joined(regions[i], regions[j]);
      regions.erase(regions.begin() + long(j));
      ++overlapping;
      j = i + 1;
    }
  for (const SectionRegion& region : regions)
    section.edges.insert(section.edges.end(), region.edges.begin(), region.edges.end());
  section.edges = withoutKeyholes(section.edges, tolerance);
  const auto say = [&](int count, const char* code, const char* what) {
    if (count > 0) notes.push_back({code, Severity::kNote, subject, std::to_string(count) + what});
  };
  say(flat, "contours.flat-left-out", " contours of less than three different points left out");
  say(twice, "contours.twice", " contours given twice taken once");
  say(crossed, "contours.crossed", " contours cross themselves: read by the even-odd rule");
  say(overlapping, "contours.joined", " pairs of contours overlap: joined");
  return section;
}

double PlaneImage::at(const Vec2d& p) const {
  if (distance.empty()) return 1e30;
  double c[2], beyond = 0;
  for (int a = 0; a < 2; ++a) {
    const double v = (p[a] - low[a]) / pixel, end = (a ? height : width) - 1;
    c[a] = std::clamp(v, 0.0, end);
    beyond += (v - c[a]) * (v - c[a]);
  }
  const int i = std::min(int(c[0]), width - 2), j = std::min(int(c[1]), height - 2);
  const double u = c[0] - i, v = c[1] - j;
  const float* f = &distance[size_t(j) * width + i];
  const double here = (1 - v) * ((1 - u) * f[0] + u * f[1]) + v * ((1 - u) * f[width] + u * f[width + 1]);
  return here + pixel * std::sqrt(beyond);
}

PlaneImage distanceImage(const PlaneSection& section, double pixel, double margin) {
  PlaneImage image;
  image.pixel = pixel;
  if (section.edges.empty()) return image;
  Vec2d low = section.edges[0].a, high = low;
  for (const Edge& e : section.edges)
    for (const Vec2d& p : {e.a, e.b})
      for (int a = 0; a < 2; ++a) low[a] = std::min(low[a], p[a]), high[a] = std::max(high[a], p[a]);
  // Multiples of `pixel`, wherever the contours are, so that pixels of neighbouring planes are
  // above each other.
  for (int a = 0; a < 2; ++a) image.low[a] = pixel * std::floor((low[a] - margin) / pixel);
  image.width = int(std::ceil((high[0] + margin - image.low[0]) / pixel)) + 1;
  image.height = int(std::ceil((high[1] + margin - image.low[1]) / pixel)) + 1;
  image.distance.assign(size_t(image.width) * image.height, 1e30f);
  image.nearest.assign(image.distance.size(), -1);
  Spread(section, image).run();
  setSigns(section, image);
  return image;
}

}  // namespace slicemorph
