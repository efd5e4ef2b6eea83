#include "engine/blend/contour_paths.h"

#include "engine/contours/contours.h"
#include "engine/match/fit_field.h"
#include "engine/slices/slice_stack.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

using Polygon = std::vector<Vec2d>;

// The figures are chosen by hand; ContourPaths.OffsetsUndoTheShrinking guards their purpose.

/// Points per resampled contour.
constexpr int kPoints = 40;
/// Nodes of the fitted offsets' lattice along its longest side, and stiffness of the fit (see fitFields).
constexpr double kNodes = 28, kStiffness = 1;
/// Number of sites for which the stiffness is given.
constexpr double kSites = 2000;

Vec2d directionOf(double angle) { return {std::cos(angle), std::sin(angle)}; }
double wrapped(double angle) { return std::remainder(angle, 2 * M_PI); }

Polygon linearBlend(const std::vector<Polygon>& polygons, const Weights& weights) {
  Polygon result(polygons[0].size(), Vec2d(0.0));
  for (size_t k = 0; k < polygons.size(); ++k)
    for (size_t i = 0; i < result.size(); ++i) result[i] += weights[k] * polygons[k][i];
  return result;
}

Vec2d middleOf(const Polygon& polygon) {
  Vec2d sum(0.0);
  for (const Vec2d& p : polygon) sum += p;
  return sum / double(polygon.size());
}

/// Rotates and moves a polygon onto another one, least squares over its points.
Polygon laidOn(const Polygon& polygon, const Polygon& onto) {
  const Vec2d from = middleOf(polygon), to = middleOf(onto);
  double along = 0, across = 0;
  for (size_t i = 0; i < polygon.size(); ++i) {
    const Vec2d a = polygon[i] - from, b = onto[i] - to;
    along += a.dot(b), across += a[0] * b[1] - a[1] * b[0];
  }
  const Vec2d turn = directionOf(std::atan2(across, along));
  Polygon result;
  for (const Vec2d& p : polygon) {
    const Vec2d a = p - from;
    result.push_back(to + Vec2d(turn[0] * a[0] - turn[1] * a[1], turn[1] * a[0] + turn[0] * a[1]));
  }
  return result;
}

/// Edge lengths and directions; each edge turns from the one before by less than half a turn.
struct Edges {
  std::vector<double> length, angle;
};

Edges edgesOf(const Polygon& polygon) {
  Edges edges;
  const size_t n = polygon.size();
  for (size_t i = 0; i < n; ++i) {
    const Vec2d e = polygon[(i + 1) % n] - polygon[i];
    edges.length.push_back(e.length());
    const double angle = std::atan2(e[1], e[0]);
    edges.angle.push_back(i == 0 ? angle : edges.angle.back() + wrapped(angle - edges.angle.back()));
  }
  return edges;
}

}  // namespace

Polygon intrinsicBlend(const std::vector<Polygon>& polygons, const Weights& weights) {
  const size_t n = polygons[0].size();
  Edges mean{std::vector<double>(n, 0), std::vector<double>(n, 0)};
  std::vector<double> shortest(n, 1e300), longest(n, 0);
  double first = 0, size = 0;
  for (size_t k = 0; k < polygons.size(); ++k) {
    const Edges edges = edgesOf(polygons[k]);
    if (k == 0) first = edges.angle[0];
    const double turn = first + wrapped(edges.angle[0] - first) - edges.angle[0];
    for (size_t i = 0; i < n; ++i) {
      mean.length[i] += weights[k] * edges.length[i];
      mean.angle[i] += weights[k] * (edges.angle[i] + turn);
      shortest[i] = std::min(shortest[i], edges.length[i]),
      longest[i] = std::max(longest[i], edges.length[i]);
      size = std::max(size, edges.length[i]);
    }
  }
  // Close the polygon by the least change of lengths, in least squares with weights such that edges whose
  // length differs between the polygons change most [SGWM93].
  double e = 0, f = 0, g = 0;
  Vec2d gap(0.0);
  std::vector<double> ease(n);
  for (size_t i = 0; i < n; ++i) {
    const Vec2d d = directionOf(mean.angle[i]);
    ease[i] = longest[i] - shortest[i] + 1e-4 * size;
    ease[i] *= ease[i];
    e += ease[i] * d[0] * d[0], f += ease[i] * d[0] * d[1], g += ease[i] * d[1] * d[1];
    gap += mean.length[i] * d;
  }
  const double det = e * g - f * f;
  const Vec2d pull = det > 1e-12 * (e + g) * (e + g)
                         ? Vec2d(g * gap[0] - f * gap[1], e * gap[1] - f * gap[0]) / det
                         : Vec2d(0.0);
  Polygon result{Vec2d(0.0)};
  for (size_t i = 0; i + 1 < n; ++i) {
    const Vec2d d = directionOf(mean.angle[i]);
    result.push_back(result.back() + (mean.length[i] - ease[i] * pull.dot(d)) * d);
  }
  return laidOn(result, linearBlend(polygons, weights));
}

Polygon hermiteBlend(const std::vector<Polygon>& polygons, const Weights& weights) {
  Polygon result = linearBlend(polygons, weights);
  const size_t n = result.size();
  for (size_t k = 0; k < polygons.size(); ++k)
    for (size_t i = 0; i < n; ++i) {
      Vec2d along = polygons[k][(i + 1) % n] - polygons[k][(i + n - 1) % n];
      const double length = along.length();
      if (!(length > 0)) continue;
      along /= length;
      for (size_t l = 0; l < polygons.size(); ++l)
        result[i] -=
            weights[k] * weights[k] * weights[l] * along.dot(polygons[l][i] - polygons[k][i]) * along;
    }
  return result;
}

ContourPaths::ContourPaths(ContourPath kind, const Displacements& map, const Fields& fields,
                           const std::vector<Chart>& charts, int slices)
    : kind_(kind) {
  const Vec3d extent = map.lattice.spacing * (map.lattice.size.asVec3d() - Vec3d(1));
  lattice_ = Lattice::over({map.lattice.origin, map.lattice.origin + extent},
                           std::max({extent[0], extent[1], extent[2]}) / kNodes);
  std::vector<openvdb::BBoxd> boxes(fields.size());
  for (size_t k = 0; k < fields.size(); ++k)
    for (const SurfaceSample& s : fields[k]->samples()) boxes[k].expand(charts[k].toChart(s.position));
  const SlicePlanes planes = placeSlices(boxes, slices);
  for (size_t k = 0; k < fields.size(); ++k) {
    const std::vector<SliceImage> images = sampleSlices(*fields[k], charts[k], planes);
    const MiddleGuess guess(map.lattice, map.of[k]);
    std::vector<std::vector<Loop>> found(images.size());
    tbb::parallel_for(size_t(0), images.size(), [&](size_t s) {
      for (const Contour& contour : traceContours(images[s], planes)) {
        Loop loop;
        loop.at.resize(fields.size());
        bool whole = true;
        for (const Vec2d& p : resample(contour, kPoints)) {
          const Vec3d a(planes.z0[s], p[0], p[1]);
          Vec3d middle = guess.near(a);
          whole = whole && toMiddle(map, k, a, middle);
          loop.middle.push_back(middle);
          for (size_t l = 0; l < fields.size(); ++l) {
            const Vec3d there = middle + map.at(l, middle);
            loop.at[l].emplace_back(there[1], there[2]);
          }
        }
        if (whole) found[s].push_back(std::move(loop));
      }
    });
    for (std::vector<Loop>& loops : found)
      for (Loop& loop : loops) loops_.push_back(std::move(loop));
  }
}

VectorField ContourPaths::offsets(const Weights& weights, const Lattice& lattice) const {
  std::vector<Polygon> off(loops_.size());
  tbb::parallel_for(size_t(0), loops_.size(), [&](size_t i) {
    const std::vector<Polygon>& at = loops_[i].at;
    off[i] = kind_ == ContourPath::kIntrinsic ? intrinsicBlend(at, weights) : hermiteBlend(at, weights);
    const Polygon straight = linearBlend(at, weights);
    for (size_t p = 0; p < off[i].size(); ++p) off[i][p] -= straight[p];
  });
  Sites sites;
  sites.value.resize(1);
  for (size_t i = 0; i < loops_.size(); ++i)
    for (size_t p = 0; p < off[i].size(); ++p) {
      sites.position.push_back(loops_[i].middle[p]);
      sites.weight.push_back(1);
      sites.value[0].emplace_back(0, off[i][p][0], off[i][p][1]);
    }
  const VectorField none(lattice_.count(), openvdb::Vec3s(0.f));
  const double density = double(sites.position.size()) / kSites;
  return resampleField(lattice_, fitFields(lattice_, sites, kStiffness * density, {lattice_, {none}}).of[0],
                       lattice);
}

}  // namespace slicemorph
