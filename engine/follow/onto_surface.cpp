#include "engine/follow/onto_surface.h"

#include "slicemorph/errors.h"

#include <openvdb/tools/Interpolation.h>
#include <openvdb/tools/VolumeToSpheres.h>
#include <tbb/blocked_range.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// In voxels: closer points are on the surface; farther ones are so near the band's clamped edge that it has
/// no gradient to follow.
constexpr double kThere = 1e-3, kFar = kHalfWidth - 1;
constexpr int kMostSteps = 12;  // from at most two voxels away, a voxel per step, with steps to converge

/// A level set's trilinear distance and its gradient, in voxels, at index coordinates. Each task
/// needs its own.
class Distance {
 public:
  explicit Distance(const FloatGrid& grid)
      : values_(grid.getConstAccessor()), unit_(1 / grid.voxelSize()[0]) {}

  double at(const Vec3d& p) const { return unit_ * openvdb::tools::BoxSampler::sample(values_, p); }
  Vec3d gradient(const Vec3d& p) const {
    Vec3d result;
    for (int d = 0; d < 3; ++d) {
      Vec3d half(0.0);
      half[d] = 0.5;
      result[d] = at(p + half) - at(p - half);
    }
    return result;
  }

 private:
  FloatGrid::ConstAccessor values_;
  double unit_;
};

/// Newton's method along the gradient, at most a voxel per step.
Vec3d alongGradient(Vec3d p, const Distance& distance) {
  for (int step = 0; step < kMostSteps; ++step) {
    const double d = distance.at(p);
    if (std::abs(d) < kThere) break;
    const Vec3d gradient = distance.gradient(p);
    const double squared = gradient.lengthSqr();
    if (squared < 1e-4) break;
    Vec3d move = -d / squared * gradient;
    if (move.lengthSqr() > 1) move.normalize();
    p += move;
  }
  return p;
}

}  // namespace

std::vector<Vec3d> ontoSurface(std::vector<Vec3d> points, const FloatGrid& levelSet) {
  const openvdb::math::Transform& transform = levelSet.transform();
  std::vector<char> far(points.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, points.size()),
                    [&](const tbb::blocked_range<size_t>& part) {
                      const Distance distance(levelSet);
                      for (size_t i = part.begin(); i < part.end(); ++i)
                        far[i] = std::abs(distance.at(transform.worldToIndex(points[i]))) > kFar;
                    });
  std::vector<openvdb::Vec3R> lost;
  for (size_t i = 0; i < points.size(); ++i)
    if (far[i]) lost.push_back(points[i]);
  if (!lost.empty()) {
    const auto nearest = openvdb::tools::ClosestSurfacePoint<FloatGrid>::create(levelSet);
    std::vector<float> distances;
    if (!nearest || !nearest->searchAndReplace(lost, distances))
      throw GeometryError("a frame has no surface");
    for (size_t i = 0, n = 0; i < points.size(); ++i)
      if (far[i]) points[i] = lost[n++];
  }
  tbb::parallel_for(
      tbb::blocked_range<size_t>(0, points.size()), [&](const tbb::blocked_range<size_t>& part) {
        const Distance distance(levelSet);
        for (size_t i = part.begin(); i < part.end(); ++i)
          points[i] = transform.indexToWorld(alongGradient(transform.worldToIndex(points[i]), distance));
      });
  return points;
}

double shareFacingInwards(const Mesh& mesh, const FloatGrid& levelSet) {
  const openvdb::math::Transform& transform = levelSet.transform();
  std::vector<double> facing(mesh.triangles.size());  // area, negative if facing inwards
  tbb::parallel_for(tbb::blocked_range<size_t>(0, facing.size()),
                    [&](const tbb::blocked_range<size_t>& part) {
                      const Distance distance(levelSet);
                      for (size_t i = part.begin(); i < part.end(); ++i) {
                        const openvdb::Vec3I& t = mesh.triangles[i];
                        const Vec3d a(mesh.points[t[0]]), b(mesh.points[t[1]]), c(mesh.points[t[2]]);
                        const Vec3d across = (b - a).cross(c - a) / 2;
                        const Vec3d out = distance.gradient(transform.worldToIndex((a + b + c) / 3));
                        facing[i] = std::copysign(across.length(), across.dot(out));
                      }
                    });
  double inwards = 0, all = 0;
  for (const double area : facing) all += std::abs(area), inwards += std::max(-area, 0.0);
  return all > 0 ? inwards / all : 0;
}

}  // namespace slicemorph
