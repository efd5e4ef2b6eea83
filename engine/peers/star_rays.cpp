#include "engine/peers/star_rays.h"

#include "engine/volume/moments.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// How far a point lies inside the tangent plane that it is least inside of; below 0: it is outside.
struct LeastDepth {
  double depth = 0;
  Vec3d normal{0, 0, 0};
};

LeastDepth leastDepth(const DistanceField& field, const Vec3d& p) {
  LeastDepth least{1e300, {}};
  for (const SurfaceSample& sample : field.samples()) {
    const double depth = (sample.position - p).dot(sample.normal);
    if (depth < least.depth) least = {depth, sample.normal};
  }
  return least;
}

}  // namespace

RayHit followRay(const DistanceField& field, const DistanceField::Sampler& sample, const Vec3d& from,
                 const Vec3d& direction, const std::function<bool(const Vec3d&)>& counts) {
  const double h = field.voxelSize(), shortest = h / 2;
  double longest = 0;  // to the corner of the box that is farthest from the start
  for (int a = 0; a < 3; ++a) {
    const double reach = std::max(field.box().max()[a] - from[a], from[a] - field.box().min()[a]) + 2 * h;
    longest += reach * reach;
  }
  longest = std::sqrt(longest);
  RayHit hit;
  bool found = false;
  double at = 0, value = sample(field.relative(from));
  if (value >= 0) hit.single = false;
  while (at < longest) {
    // Distances change by no more than the step, but those of the coarse grid are a little off: hence not all of it.
    const double step = std::max(shortest, 0.5 * std::abs(value));
    const double next = sample(field.relative(from + (at + step) * direction));
    if (value < 0 && next >= 0) {
      if (!found) hit.distance = at + step * value / (value - next);
      if (found && (!counts || counts(from + at * direction))) hit.single = false;
      found = true;
    }
    at += step, value = next;
  }
  if (!found) hit.single = false;
  return hit;
}

Vec3d starCentre(const DistanceField& field) {
  constexpr int kMostSteps = 2000;
  // A voxel's worth of depth: normals of a level set are no better near its edges.
  const double wanted = field.voxelSize();
  Vec3d centre = insideMoments(field).centroid;
  for (int step = 0; step < kMostSteps; ++step) {
    const LeastDepth least = leastDepth(field, centre);
    if (least.depth >= wanted) break;
    centre -= (wanted - least.depth) * least.normal;
  }
  return centre;
}

}  // namespace slicemorph
