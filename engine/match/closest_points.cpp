#include "engine/match/closest_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

namespace {

/// Trust falls from 1 at three quarters (1 - 1 / kFading) of the reach to 0 at the reach. Chosen by hand.
constexpr double kFading = 4;
/// Cosine between the normals at which trust is 0, and from which it is 1; around the
/// prototype's limit of 0.3.
constexpr double kAskew = 0.1, kFacing = 0.5;

/// A point projected onto a surface.
struct Projected {
  Vec3d at;     ///< chart coordinates; the unprojected point where trust is 0
  float trust;  ///< 0 to 1
};

/// `at`, `normal`: of the sample that is projected, chart space.
Projected projectOnto(const DistanceField& field, const Chart& chart, const Vec3d& at, const Vec3d& normal,
                      double reach) {
  const Vec3d surface = field.closest(chart.toWorld(at));
  const Vec3d projected = chart.toChart(surface);
  const double near = 1 - (projected - at).length() / reach;
  const double facing =
      (chart.normalToChart(projected, field.gradient(surface)).dot(normal) - kAskew) / (kFacing - kAskew);
  const double trust = std::min(std::max(kFading * near, 0.0), 1.0) * std::min(std::max(facing, 0.0), 1.0);
  return {trust > 0 ? projected : at, float(trust)};
}

}  // namespace

std::vector<Correspondence> closestPoints(const Fields& fields, const std::vector<Chart>& charts,
                                          const Displacements& map, const std::vector<MiddleSamples>& samples,
                                          double reach) {
  const size_t objects = charts.size();
  std::vector<Correspondence> points;
  for (size_t j = 0; j < objects; ++j) {
    std::vector<Correspondence> found(samples[j].own.size());
    tbb::parallel_for(size_t(0), found.size(), [&](size_t i) {
      Correspondence& c = found[i];
      const Vec3d& s = samples[j].points.position[i];
      c.weight = 0;
      c.middle = s;
      for (size_t k = 0; k < objects; ++k) {
        const Vec3d before = k == j ? samples[j].own[i] : s + map.at(k, s);
        Projected on{before, 0};
        if (k != j && fields[k])
          on = projectOnto(*fields[k], charts[k], before, samples[j].points.normal[i], reach);
        c.weight = std::max(c.weight, on.trust);
        c.at.push_back(on.at);
        c.middle += (on.at - before) / double(objects);
      }
    });
    for (Correspondence& c : found)
      if (c.weight > 0) points.push_back(std::move(c));
  }
  return points;
}

}  // namespace slicemorph
