#include "engine/match/meeting_points.h"

#include <tbb/parallel_for.h>

#include <algorithm>

namespace slicemorph {

namespace {

/// Trust falls from 1 at three quarters (1 - 1 / kFading) of the reach to 0 at the reach. Chosen by hand.
constexpr double kFading = 4;

}  // namespace

double trustAt(double distance, double reach) {
  return std::clamp(kFading * (1 - distance / reach), 0.0, 1.0);
}

std::vector<Correspondence> meetingPoints(
    size_t object, size_t objects, const Displacements& map, const MiddleSamples& samples,
    const std::function<Projected(size_t k, const Vec3d& before, size_t i)>& project) {
  std::vector<Correspondence> found(samples.own.size());
  tbb::parallel_for(size_t(0), found.size(), [&](size_t i) {
    Correspondence& c = found[i];
    const Vec3d& s = samples.points.position[i];
    c.weight = 0;
    c.middle = s;
    for (size_t k = 0; k < objects; ++k) {
      const Vec3d before = k == object ? samples.own[i] : s + map.at(k, s);
      const Projected on = k == object ? Projected{before, 0} : project(k, before, i);
      c.weight = std::max(c.weight, on.trust);
      c.at.push_back(on.at);
      c.middle += (on.at - before) / double(objects);
    }
  });
  std::vector<Correspondence> points;
  for (Correspondence& c : found)
    if (c.weight > 0) points.push_back(std::move(c));
  return points;
}

}  // namespace slicemorph
