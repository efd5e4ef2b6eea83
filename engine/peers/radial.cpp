#include "engine/peers/radial.h"

#include "engine/numerics/parallel_each.h"
#include "engine/peers/require.h"
#include "engine/peers/ring_mesh.h"
#include "engine/peers/star_rays.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// The largest distance of the surface from a point.
double farthestFrom(const DistanceField& field, const Vec3d& p) {
  double farthest = 0;
  for (const SurfaceSample& sample : field.samples())
    farthest = std::max(farthest, (sample.position - p).length());
  return farthest;
}

RingLayout layoutFor(double farthest, double voxelSize) {
  RingLayout layout;
  const double around = std::ceil(2 * openvdb::math::pi<double>() * farthest / voxelSize);
  requireAtMost("--method radial needs a ray for each voxel of a sphere about an object, which are ",
                around * around / 2, RadialMorph::kMostRays);
  layout.around = std::max(int(around), 16);
  layout.rings = layout.around / 2;
  return layout;
}

/// Throws InputError unless every ray leaves the object once.
void requireStar(const std::vector<char>& single, const std::string& name) {
  const size_t bad = size_t(std::count(single.begin(), single.end(), 0));
  if (bad == 0) return;
  throw InputError("--method radial: '" + name +
                   "' is not star-shaped: from the best centre that was found " + std::to_string(bad) +
                   " of " + std::to_string(single.size()) +
                   " rays leave it more than once; use another method, such as --method slices");
}

}  // namespace

RadialMorph::RadialMorph(const std::vector<Object>& objects, double voxelSize, const RadialOptions& options)
    : voxelSize_(voxelSize) {
  if (options.tangent > 0 && objects.size() != 2)
    throw InputError("--method radial: paths with tangents lead from one object to another; there are " +
                     std::to_string(objects.size()) + " objects: choose tangent=0");
  std::vector<std::unique_ptr<DistanceField>> fields(objects.size());
  stars_.resize(objects.size());
  parallelEach(objects.size(), [&](size_t k) {
    fields[k] = std::make_unique<DistanceField>(objects[k].levelSet);
    stars_[k].centre = starCentre(*fields[k]);
  });
  double farthest = 0;
  for (size_t k = 0; k < objects.size(); ++k)
    farthest = std::max(farthest, farthestFrom(*fields[k], stars_[k].centre));
  const RingLayout layout = layoutFor(farthest, voxelSize);
  rings_ = layout.rings, around_ = layout.around;

  double radii = 0;
  for (size_t k = 0; k < objects.size(); ++k) {
    Star& star = stars_[k];
    star.reach.resize(layout.count());
    if (options.tangent > 0) star.normal.resize(layout.count());
    std::vector<char> single(layout.count());
    tbb::parallel_for(tbb::blocked_range<size_t>(0, layout.count(), 256), [&](const auto& range) {
      const DistanceField::Sampler sample(*fields[k]);
      for (size_t i = range.begin(); i != range.end(); ++i) {
        const Vec3d direction = layout.direction(i);
        const RayHit hit = followRay(*fields[k], sample, star.centre, direction);
        single[i] = hit.single;
        star.reach[i] = openvdb::Vec3s(hit.distance * direction);
        if (!star.normal.empty())
          star.normal[i] =
              sample.gradient(fields[k]->relative(star.centre + hit.distance * direction)).unit();
      }
    });
    requireStar(single, objects[k].name);
    for (const openvdb::Vec3s& reach : star.reach) radii += double(reach.length()) / double(layout.count());
  }
  tangent_ = options.tangent * radii / double(objects.size());
}

FloatGrid::Ptr RadialMorph::frame(const Weights& weights) const {
  requireWeights(weights, stars_.size());
  const RingLayout layout{rings_, around_};
  Vec3d centre(0.0);
  for (size_t k = 0; k < stars_.size(); ++k) centre += weights[k] * stars_[k].centre;
  // The two tangents' Hermite polynomials at time t, where the first object's weight is 1 - t.
  const double t = weights.back();
  const double leave = tangent_ * t * (1 - t) * (1 - t), arrive = -tangent_ * t * t * (1 - t);
  const double blend = t * t * (3 - 2 * t);

  Mesh mesh;
  mesh.points.resize(layout.count());
  std::vector<char> turned(layout.count(), 0);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, layout.count(), 4096), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) {
      Vec3d reach(0.0);
      if (tangent_ > 0)
        reach = (1 - blend) * Vec3d(stars_[0].reach[i]) + blend * Vec3d(stars_[1].reach[i]) +
                leave * Vec3d(stars_[0].normal[i]) + arrive * Vec3d(stars_[1].normal[i]);
      else
        for (size_t k = 0; k < stars_.size(); ++k) reach += weights[k] * Vec3d(stars_[k].reach[i]);
      turned[i] = reach.dot(Vec3d(stars_[0].reach[i])) <= 0;
      mesh.points[i] = openvdb::Vec3s(centre + reach);
    }
  });
  if (tangent_ == 0 && std::count(turned.begin(), turned.end(), 1) > 0)
    throw InputError(
        "--method radial: at these weights a radius is below 0; none of them must be far below 0");
  mesh.triangles = layout.triangles();
  return levelSetOfMesh(mesh, voxelSize_);
}

}  // namespace slicemorph
