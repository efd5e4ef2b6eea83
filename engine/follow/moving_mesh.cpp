#include "engine/follow/moving_mesh.h"

#include "engine/follow/onto_surface.h"
#include "engine/measure/measure.h"
#include "engine/volume/surface_colors.h"
#include "engine/volume/voxelise.h"
#include "slicemorph/errors.h"

#include <cmath>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

MovingMesh still(size_t frame, Mesh mesh) {
  return {frame, std::move(mesh.triangles), {std::move(mesh.points)}};
}

class Follower {
 public:
  Follower(const std::vector<SurfaceFrame>& frames, const MorphPlan& plan, const FollowLimits& limits,
           Progress& progress)
      : frames_(frames), plan_(plan), limits_(limits), progress_(progress) {}

  /// Frames `first` to `last` - 1, in order.
  void follow(size_t first, size_t last) {
    if (first >= last) return;
    if (progress_.cancelled()) throw Cancelled();
    progress_.report("following surfaces", double(done_) / double(frames_.size()));
    const size_t middle = (first + last - 1) / 2;
    const Mesh mesh = surfaceOf(*frames_[middle].surface);
    if (mesh.triangles.empty()) {
      follow(first, middle);
      meshes_.push_back(still(middle, mesh));
      ++done_;
      return follow(middle + 1, last);
    }
    size_t begin = middle, end = middle + 1;
    std::vector<std::vector<Vec3s>> before, after{mesh.points};
    for (std::vector<Vec3s> there; end < last && carry(mesh, middle, end, there); ++end)
      after.push_back(std::move(there));
    for (std::vector<Vec3s> there; begin > first && carry(mesh, middle, begin - 1, there); --begin)
      before.push_back(std::move(there));
    done_ += end - begin;
    follow(first, begin);
    MovingMesh moving{begin, mesh.triangles, {before.rbegin(), before.rend()}};
    moving.points.insert(moving.points.end(), after.begin(), after.end());
    meshes_.push_back(std::move(moving));
    follow(end, last);
  }

  std::vector<MovingMesh> take() { return std::move(meshes_); }

 private:
  /// Carries a frame's mesh to another frame. Returns whether it may represent that frame's surface.
  bool carry(const Mesh& mesh, size_t from, size_t to, std::vector<Vec3s>& there) const {
    if (progress_.cancelled()) throw Cancelled();
    const FloatGrid& surface = *frames_[to].surface;
    const Mesh own = surfaceOf(surface);
    if (own.triangles.empty()) return false;
    std::vector<Vec3d> points(mesh.points.begin(), mesh.points.end());
    points = ontoSurface(plan_.carryPoints(points, frames_[from].weights, frames_[to].weights), surface);
    const Mesh moved{{points.begin(), points.end()}, mesh.triangles};
    there = moved.points;
    return standsFor(moved, own, surface);
  }

  bool standsFor(const Mesh& moved, const Mesh& own, const FloatGrid& surface) const {
    const double voxel = surface.voxelSize()[0];
    const ShapeMeasures is = measureMesh(moved), wanted = measureMesh(own);
    if (std::abs(is.volume - wanted.volume) > limits_.mean * voxel * wanted.area) return false;
    if (shareFacingInwards(moved, surface) > limits_.inwards) return false;
    const SurfaceDistance distance = distanceTo(own.points, moved);
    return distance.max <= limits_.most * voxel && distance.p99 <= limits_.p99 * voxel;
  }

  const std::vector<SurfaceFrame>& frames_;
  const MorphPlan& plan_;
  const FollowLimits& limits_;
  Progress& progress_;
  size_t done_ = 0;
  std::vector<MovingMesh> meshes_;
};

/// Sets the meshes' colours; leaves them empty if any frame with triangles has no colours.
void addColors(std::vector<MovingMesh>& meshes, const std::vector<SurfaceFrame>& frames) {
  for (const MovingMesh& m : meshes)
    for (size_t i = 0; i < m.points.size() && !m.triangles.empty(); ++i)
      if (!frames[m.first + i].colors) return;
  for (MovingMesh& m : meshes)
    for (size_t i = 0; i < m.points.size() && !m.triangles.empty(); ++i)
      m.colors.push_back(colorsAt(*frames[m.first + i].colors, m.points[i]));
}

}  // namespace

std::vector<MovingMesh> followSurfaces(const std::vector<SurfaceFrame>& frames, const MorphPlan* plan,
                                       const FollowLimits& limits, Progress* progress) {
  Progress none;
  std::vector<MovingMesh> meshes;
  if (plan) {
    Follower follower(frames, *plan, limits, progress ? *progress : none);
    follower.follow(0, frames.size());
    meshes = follower.take();
  } else {
    for (size_t i = 0; i < frames.size(); ++i) meshes.push_back(still(i, surfaceOf(*frames[i].surface)));
  }
  addColors(meshes, frames);
  return meshes;
}

}  // namespace slicemorph
