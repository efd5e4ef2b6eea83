#include "engine/follow/moving_mesh.h"

#include "engine/errors.h"
#include "engine/follow/onto_surface.h"
#include "engine/follow/ride.h"
#include "engine/measure/measure.h"
#include "engine/volume/voxelise.h"

#include <algorithm>
#include <cmath>
#include <optional>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

class Follower {
 public:
  Follower(const std::vector<SurfaceFrame>& frames, const MorphPlan& plan, const FollowLimits& limits, Progress& progress)
      : frames_(frames), plan_(plan), limits_(limits), progress_(progress) {}

  /// Frames `first` to `last` - 1.
  void follow(size_t first, size_t last) {
    if (first >= last) return;
    if (progress_.cancelled()) throw Cancelled();
    progress_.report("following surfaces", double(done_) / double(frames_.size()));
    const size_t middle = (first + last - 1) / 2;
    Mesh mesh = surfaceOf(*frames_[middle].surface);
    MovingMesh moving{middle, mesh.triangles, {mesh.points}};
    for (size_t i = middle; i + 1 < last; ++i) {
      if (!step(i, i + 1, mesh)) break;
      moving.points.push_back(mesh.points);
    }
    mesh.points = moving.points.front();
    std::vector<std::vector<Vec3s>> before;
    for (size_t i = middle; i > first; --i) {
      if (!step(i, i - 1, mesh)) break;
      before.push_back(mesh.points);
    }
    moving.first = middle - before.size();
    moving.points.insert(moving.points.begin(), before.rbegin(), before.rend());
    done_ += moving.points.size();
    const size_t begin = moving.first, end = begin + moving.points.size();
    follow(first, begin);
    meshes_.push_back(std::move(moving));
    follow(end, last);
  }

  std::vector<MovingMesh> take() { return std::move(meshes_); }

 private:
  /// Takes a mesh from one frame to another. Returns whether it stands for that one.
  bool step(size_t from, size_t to, Mesh& mesh) const {
    const FloatGrid& surface = *frames_[to].surface;
    std::vector<Vec3d> points(mesh.points.begin(), mesh.points.end());
    points = ride(plan_, std::move(points), frames_[from].weights, frames_[to].weights, surface.voxelSize()[0]);
    points = ontoSurface(std::move(points), surface);
    std::copy(points.begin(), points.end(), mesh.points.begin());
    return isNear(mesh, surface);
  }

  bool isNear(const Mesh& mesh, const FloatGrid& surface) const {
    const Mesh own = surfaceOf(surface);
    const ShapeMeasures is = measureMesh(mesh), wanted = measureMesh(own);
    if (std::abs(is.volume - wanted.volume) > limits_.volume * wanted.volume) return false;
    if (std::abs(is.area - wanted.area) > limits_.area * wanted.area) return false;
    const double voxel = surface.voxelSize()[0];
    const SurfaceDistance distance = distanceTo(own.points, mesh);
    return distance.max <= limits_.most * voxel && distance.p99 <= limits_.p99 * voxel;
  }

  const std::vector<SurfaceFrame>& frames_;
  const MorphPlan& plan_;
  const FollowLimits& limits_;
  Progress& progress_;
  size_t done_ = 0;
  std::vector<MovingMesh> meshes_;
};

}  // namespace

std::vector<MovingMesh> followSurfaces(const std::vector<SurfaceFrame>& frames, const MorphPlan* plan,
                                       const FollowLimits& limits, Progress* progress) {
  Progress none;
  if (plan) {
    Follower follower(frames, *plan, limits, progress ? *progress : none);
    follower.follow(0, frames.size());
    return follower.take();
  }
  std::vector<MovingMesh> meshes;
  for (size_t i = 0; i < frames.size(); ++i) {
    Mesh mesh = surfaceOf(*frames[i].surface);
    meshes.push_back({i, std::move(mesh.triangles), {std::move(mesh.points)}});
  }
  return meshes;
}

}  // namespace slicemorph
