#include "engine/match/closest_points.h"

#include "engine/match/meeting_points.h"

#include <algorithm>

namespace slicemorph {

namespace {

/// Cosine between the normals at which trust is 0, and from which it is 1; around the
/// prototype's limit of 0.3.
constexpr double kAskew = 0.1, kFacing = 0.5;

/// `at`, `normal`: of the sample that is projected, chart space.
Projected projectOnto(const DistanceField& field, const Chart& chart, const Vec3d& at, const Vec3d& normal,
                      double reach) {
  const Vec3d surface = field.closest(chart.toWorld(at));
  const Vec3d projected = chart.toChart(surface);
  const double facing =
      (chart.normalToChart(projected, field.gradient(surface)).dot(normal) - kAskew) / (kFacing - kAskew);
  const double trust = trustAt((projected - at).length(), reach) * std::min(std::max(facing, 0.0), 1.0);
  return {trust > 0 ? projected : at, float(trust)};
}

}  // namespace

std::vector<Correspondence> closestPoints(const Fields& fields, const std::vector<Chart>& charts,
                                          const Displacements& map, const std::vector<MiddleSamples>& samples,
                                          double reach) {
  std::vector<Correspondence> points;
  for (size_t j = 0; j < charts.size(); ++j) {
    const auto project = [&](size_t k, const Vec3d& before, size_t i) {
      if (!fields[k]) return Projected{before, 0};
      return projectOnto(*fields[k], charts[k], before, samples[j].points.normal[i], reach);
    };
    for (Correspondence& c : meetingPoints(j, charts.size(), map, samples[j], project))
      points.push_back(std::move(c));
  }
  return points;
}

}  // namespace slicemorph
