#include "engine/match/contour_pairs.h"

#include "engine/match/assignment.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

/// From the method's prototype, which accepted pairs from an overlap of 0.35 to 0.5. Without the limit a
/// sphere that became a torus fell into five pieces there.
constexpr double kTrustedOverlap = 0.4;
/// Per chart unit, and per factor e of the areas; from the prototype.
constexpr double kCentroidPrice = 1.2, kAreaPrice = 0.35;

/// A contour mapped to the middle slice.
struct Carried {
  std::vector<Vec2d> points;
  Vec2d centroid{0, 0}, low{0, 0}, high{0, 0};
  double area = 0;
};

Carried carryContour(const Contour& c, const BaseWarp& base, size_t object, size_t slice) {
  Carried r;
  for (const Vec2d& p : c.points) r.points.push_back(toMiddle(base, object, slice, p));
  r.low = r.high = r.points[0];
  Vec2d moment(0.0);
  for (size_t i = 0, n = r.points.size(); i < n; ++i) {
    const Vec2d &a = r.points[i], &b = r.points[(i + 1) % n];
    const double k = a[0] * b[1] - a[1] * b[0];
    r.area += k / 2, moment += k / 6 * (a + b);
    for (int d = 0; d < 2; ++d) r.low[d] = std::min(r.low[d], a[d]), r.high[d] = std::max(r.high[d], a[d]);
  }
  r.centroid = r.area != 0 ? moment / r.area : r.points[0];
  return r;
}

/// Intersection over union of two polygons, by 64 scan lines.
double overlapOf(const Carried& a, const Carried& b) {
  constexpr int kLines = 64;
  const double low = std::min(a.low[1], b.low[1]), high = std::max(a.high[1], b.high[1]);
  double both = 0, either = 0;
  const auto crossings = [](const Carried& c, double y) {
    std::vector<double> x;
    for (size_t i = 0, n = c.points.size(), j = n - 1; i < n; j = i++) {
      const Vec2d &p = c.points[i], &q = c.points[j];
      if ((p[1] > y) != (q[1] > y)) x.push_back(p[0] + (y - p[1]) / (q[1] - p[1]) * (q[0] - p[0]));
    }
    std::sort(x.begin(), x.end());
    return x;
  };
  for (int line = 0; line < kLines; ++line) {
    const double y = low + (line + 0.5) / kLines * (high - low);
    const std::vector<double> xa = crossings(a, y), xb = crossings(b, y);
    double la = 0, lb = 0, shared = 0;
    for (size_t i = 0; i + 1 < xa.size(); i += 2) la += xa[i + 1] - xa[i];
    for (size_t i = 0; i + 1 < xb.size(); i += 2) lb += xb[i + 1] - xb[i];
    for (size_t i = 0; i + 1 < xa.size(); i += 2)
      for (size_t j = 0; j + 1 < xb.size(); j += 2)
        shared += std::max(0.0, std::min(xa[i + 1], xb[j + 1]) - std::max(xa[i], xb[j]));
    both += shared, either += la + lb - shared;
  }
  return either > 0 ? both / either : 0;
}

std::vector<ContourPair> matchSlice(const std::vector<Contour>& a, const std::vector<Contour>& b,
                                    const BaseWarp& base, size_t slice, size_t objectA, size_t objectB) {
  std::vector<ContourPair> pairs;
  if (a.empty() || b.empty()) return pairs;
  std::vector<Carried> ca, cb;
  for (const Contour& c : a) ca.push_back(carryContour(c, base, objectA, slice));
  for (const Contour& c : b) cb.push_back(carryContour(c, base, objectB, slice));
  const bool flip = a.size() > b.size();
  const size_t rows = flip ? b.size() : a.size(), columns = flip ? a.size() : b.size();
  std::vector<std::vector<double>> cost(rows, std::vector<double>(columns));
  for (size_t i = 0; i < rows; ++i)
    for (size_t j = 0; j < columns; ++j) {
      const Carried &x = ca[flip ? j : i], &y = cb[flip ? i : j];
      cost[i][j] = (x.area < 0) == (y.area < 0)
                       ? kCentroidPrice * (x.centroid - y.centroid).length() +
                             kAreaPrice * std::abs(std::log(std::abs(x.area / y.area)))
                       : 1e6;
    }
  const std::vector<int> assigned = assign(cost);
  for (size_t i = 0; i < rows; ++i) {
    if (assigned[i] < 0 || cost[i][size_t(assigned[i])] > 1e5) continue;
    const size_t ia = flip ? size_t(assigned[i]) : i, ib = flip ? i : size_t(assigned[i]);
    const double overlap = overlapOf(ca[ia], cb[ib]);
    if (overlap >= kTrustedOverlap) pairs.push_back({slice, objectA, ia, objectB, ib, overlap});
  }
  return pairs;
}

/// The cyclic shift of b's points that correlates best with a's.
int bestStart(const std::vector<Vec2d>& a, const std::vector<Vec2d>& b) {
  const int n = int(a.size());
  int best = 0;
  double most = -std::numeric_limits<double>::max();
  for (int shift = 0; shift < n; ++shift) {
    double sum = 0;
    for (int i = 0; i < n; ++i) sum += a[i].dot(b[(i + shift) % n]);
    if (sum > most) most = sum, best = shift;
  }
  return best;
}

/// Every object with the next one, and the last with the first.
std::vector<std::pair<size_t, size_t>> neighbours(size_t objects) {
  std::vector<std::pair<size_t, size_t>> pairs;
  for (size_t k = 0; k + 1 < objects; ++k) pairs.emplace_back(k, k + 1);
  if (objects > 2) pairs.emplace_back(0, objects - 1);
  return pairs;
}

}  // namespace

std::vector<ContourPair> matchContours(const std::vector<ContourStack>& stacks, const BaseWarp& base) {
  const size_t slices = base.z0.size();
  std::vector<std::vector<ContourPair>> perSlice(slices);
  tbb::parallel_for(size_t(0), slices, [&](size_t s) {
    for (const auto& [j, k] : neighbours(stacks.size()))
      for (const ContourPair& pair : matchSlice(stacks[j][s], stacks[k][s], base, s, j, k))
        perSlice[s].push_back(pair);
  });
  std::vector<ContourPair> pairs;
  for (const auto& p : perSlice) pairs.insert(pairs.end(), p.begin(), p.end());
  return pairs;
}

std::vector<Correspondence> pairCorrespondences(const std::vector<ContourPair>& pairs,
                                                const std::vector<ContourStack>& stacks, const BaseWarp& base,
                                                int samples) {
  std::vector<std::vector<Correspondence>> perPair(pairs.size());
  tbb::parallel_for(size_t(0), pairs.size(), [&](size_t p) {
    const ContourPair& pair = pairs[p];
    const std::vector<Vec2d> a = resample(stacks[pair.objectA][pair.slice][pair.contourA], samples);
    const std::vector<Vec2d> b = resample(stacks[pair.objectB][pair.slice][pair.contourB], samples);
    std::vector<Vec2d> ma, mb;
    for (const Vec2d& q : a) ma.push_back(toMiddle(base, pair.objectA, pair.slice, q));
    for (const Vec2d& q : b) mb.push_back(toMiddle(base, pair.objectB, pair.slice, q));
    const int shift = bestStart(ma, mb);
    for (int i = 0; i < samples; ++i) {
      const Vec2d &pa = a[i], &pb = b[(i + shift) % samples];
      const Vec2d middle = 0.5 * (ma[i] + mb[(i + shift) % samples]);
      Correspondence c;
      for (size_t k = 0; k < stacks.size(); ++k) {
        // An object that is not part of this pair follows the base warp.
        const SliceAffine &m = base.middle[pair.slice], &o = base.objects[k][pair.slice];
        const double det = m.xx * m.yy - m.xy * m.xy;
        const Vec2d d = middle - m.mean;
        const Vec2d q((m.yy * d[0] - m.xy * d[1]) / det, (m.xx * d[1] - m.xy * d[0]) / det);
        const Vec2d follows = o.mean + Vec2d(o.xx * q[0] + o.xy * q[1], o.xy * q[0] + o.yy * q[1]);
        const Vec2d at = k == pair.objectA ? pa : k == pair.objectB ? pb : follows;
        c.at.emplace_back(base.position[k][pair.slice], at[0], at[1]);
        c.middle += c.at.back() / double(stacks.size());
      }
      perPair[p].push_back(std::move(c));
    }
  });
  std::vector<Correspondence> all;
  for (const auto& list : perPair) all.insert(all.end(), list.begin(), list.end());
  return all;
}

}  // namespace slicemorph
