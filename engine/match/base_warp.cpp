#include "engine/match/base_warp.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// Standard deviation of the smoothing along the spine, in slices: the value of the method's prototype,
/// tested by BaseWarp.IsSmoothedOverFourSlices.
constexpr double kSmoothSlices = 4;
/// No slice is stretched or squeezed by more (square root of the area ratio); later steps do the rest. Chosen
/// by hand.
constexpr double kLargestStretch = 1.8;

SliceAffine squareRoot(const SliceMoments& m) {
  // sqrt(C) = (C + sqrt(det) I) / sqrt(trace + 2 sqrt(det)) for a symmetric 2 x 2 matrix.
  const double s = std::sqrt(std::max(m.xx * m.yy - m.xy * m.xy, 0.0));
  const double t = std::sqrt(std::max(m.xx + m.yy + 2 * s, 1e-12));
  return {m.mean, (m.xx + s) / t, m.xy / t, (m.yy + s) / t};
}

/// Gaussian mean over the slices, weighted by their areas (at most the median), so that empty slices take
/// their neighbours' values.
std::vector<SliceAffine> smoothed(const std::vector<SliceMoments>& moments) {
  const int n = int(moments.size());
  double median = 0;
  std::vector<double> areas;
  for (const auto& m : moments)
    if (m.area > 0) areas.push_back(m.area);
  if (!areas.empty()) {
    std::nth_element(areas.begin(), areas.begin() + areas.size() / 2, areas.end());
    median = areas[areas.size() / 2];
  }
  std::vector<SliceAffine> result(n);
  for (int i = 0; i < n; ++i) {
    double total = 0;
    SliceAffine sum{{0, 0}, 0, 0, 0};
    for (int j = 0; j < n; ++j) {
      if (!(moments[j].area > 0)) continue;
      const double d = (i - j) / kSmoothSlices;
      // The second term's long tail keeps the mean defined at empty ends.
      const double w =
          std::min(moments[j].area / median, 1.0) * (std::exp(-0.5 * d * d) + 1e-9 / (1 + d * d * d * d));
      const SliceAffine a = squareRoot(moments[j]);
      total += w, sum.mean += w * a.mean, sum.xx += w * a.xx, sum.xy += w * a.xy, sum.yy += w * a.yy;
    }
    if (total > 0) result[i] = {sum.mean / total, sum.xx / total, sum.xy / total, sum.yy / total};
  }
  return result;
}

SliceAffine interpolate(const SliceAffine& a, const SliceAffine& b, double t) {
  return {a.mean + t * (b.mean - a.mean), a.xx + t * (b.xx - a.xx), a.xy + t * (b.xy - a.xy),
          a.yy + t * (b.yy - a.yy)};
}

/// to.root * from.root^-1 (p - from.mean) + to.mean
Vec2d carry(const SliceAffine& from, const SliceAffine& to, const Vec2d& p) {
  const Vec2d d = p - from.mean;
  const double det = from.xx * from.yy - from.xy * from.xy;
  const Vec2d q((from.yy * d[0] - from.xy * d[1]) / det, (from.xx * d[1] - from.xy * d[0]) / det);
  return to.mean + Vec2d(to.xx * q[0] + to.xy * q[1], to.xy * q[0] + to.yy * q[1]);
}

/// Scales an object's root so that its stretch against the middle's is at most kLargestStretch.
SliceAffine bounded(const SliceAffine& a, const SliceAffine& middle) {
  const double stretch =
      std::sqrt((a.xx * a.yy - a.xy * a.xy) / (middle.xx * middle.yy - middle.xy * middle.xy));
  const double allowed = std::min(std::max(stretch, 1 / kLargestStretch), kLargestStretch) / stretch;
  return {a.mean, a.xx * allowed, a.xy * allowed, a.yy * allowed};
}

}  // namespace

BaseWarp makeBaseWarp(const std::vector<ContourStack>& stacks, const SlicePlanes& planes,
                      const std::vector<std::vector<double>>& position) {
  BaseWarp base;
  base.z0 = planes.z0;
  base.position = position;
  const size_t slices = planes.z0.size();
  for (const ContourStack& stack : stacks) {
    std::vector<SliceMoments> moments;
    for (const auto& contours : stack) moments.push_back(momentsOf(contours));
    base.objects.push_back(smoothed(moments));
  }
  base.middle.assign(slices, {{0, 0}, 0, 0, 0});
  const double share = 1.0 / double(stacks.size());
  for (size_t i = 0; i < slices; ++i) {
    SliceAffine& m = base.middle[i];
    for (const auto& o : base.objects) {
      m.mean += share * o[i].mean;
      m.xx += share * o[i].xx, m.xy += share * o[i].xy, m.yy += share * o[i].yy;
    }
    for (auto& o : base.objects) o[i] = bounded(o[i], m);
  }
  return base;
}

Vec2d toMiddle(const BaseWarp& base, size_t object, size_t slice, const Vec2d& p) {
  return carry(base.objects[object][slice], base.middle[slice], p);
}

Displacements baseDisplacements(const BaseWarp& base, const Lattice& lattice, const openvdb::BBoxd& box) {
  const size_t objects = base.objects.size();
  Displacements map{lattice,
                    std::vector<VectorField>(objects, VectorField(lattice.count(), openvdb::Vec3s(0.f)))};
  const double step = base.z0[1] - base.z0[0];
  const Vec3d margin = box.min() - lattice.origin;
  std::vector<Vec2d> d(objects);
  for (int z = 0; z < lattice.size[2]; ++z)
    for (int y = 0; y < lattice.size[1]; ++y)
      for (int x = 0; x < lattice.size[0]; ++x) {
        const Vec3d s = lattice.position(x, y, z);
        double fade = 1;
        for (int a = 0; a < 3; ++a) {
          const double out = std::max({box.min()[a] - s[a], s[a] - box.max()[a], 0.0}) / margin[a];
          fade *= std::max(1 - out, 0.0);
        }
        const double at = std::min(std::max((s[0] - base.z0[0]) / step, 0.0), double(base.z0.size() - 1));
        const size_t i = std::min(size_t(at), base.z0.size() - 2);
        const double t = at - double(i);
        const SliceAffine middle = interpolate(base.middle[i], base.middle[i + 1], t);
        const Vec2d p(s[1], s[2]);
        Vec2d mean(0.0);
        for (size_t k = 0; k < objects; ++k) {
          d[k] = carry(middle, interpolate(base.objects[k][i], base.objects[k][i + 1], t), p) - p;
          mean += d[k] / double(objects);
        }
        for (size_t k = 0; k < objects; ++k) {
          const Vec2d e = fade * (d[k] - mean);
          const std::vector<double>& position = base.position[k];
          const double along =
              fade * ((1 - t) * (position[i] - base.z0[i]) + t * (position[i + 1] - base.z0[i + 1]));
          map.of[k][lattice.index(x, y, z)] = openvdb::Vec3s(float(along), float(e[0]), float(e[1]));
        }
      }
  return map;
}

}  // namespace slicemorph
