#include "engine/volume/thin_parts.h"

#include "engine/volume/mesh_measures.h"
#include "engine/volume/surface_samples.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

namespace slicemorph {

namespace {

/// About `count` points of a mesh that bound nothing in its level set.
struct LostPoints {
  std::vector<Vec3d> lost;
  size_t all = 0;  ///< how many were looked at
};

LostPoints lostPoints(const Mesh& mesh, const FloatGrid& levelSet, size_t count) {
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  const double half = 0.5 * levelSet.voxelSize()[0];
  const auto accessor = levelSet.getConstAccessor();
  const auto isInside = [&](const Vec3d& p) {
    return openvdb::tools::BoxSampler::sample(accessor, levelSet.worldToIndex(p)) < 0;
  };
  LostPoints points;
  for (const SurfacePoint& s : sampleSurface(mesh, all, count)) {
    ++points.all;
    if (!isInside(s.point - half * s.normal) && !isInside(s.point + half * s.normal))
      points.lost.push_back(s.point);
  }
  return points;
}

/// Points per square voxel whose balls, as thick as a wall is to be, cover it.
constexpr double kPointsPerVoxel = 4;
/// Of a surface of more than a million square voxels there are fewer; a quarter as many still cover it, so up to four
/// million. Beyond, thin walls are kept with gaps.
constexpr double kMostPoints = 1 << 22;

}  // namespace

double lostShare(const Mesh& mesh, const FloatGrid& levelSet) {
  constexpr size_t kPoints = 20000;
  const LostPoints points = lostPoints(mesh, levelSet, kPoints);
  return points.all > 0 ? double(points.lost.size()) / double(points.all) : 0;
}

FloatGrid::Ptr withThinWalls(const FloatGrid& levelSet, const Mesh& mesh) {
  FloatGrid::Ptr grid = levelSet.deepCopy();
  const double h = grid->voxelSize()[0], background = grid->background(), half = 0.5 * kKeptWall;
  const double count = kPointsPerVoxel * areaOf(mesh) / (h * h);
  auto values = grid->getAccessor();
  for (const Vec3d& p : lostPoints(mesh, levelSet, size_t(std::clamp(count, 1.0, kMostPoints))).lost) {
    const Vec3d at = grid->worldToIndex(p);
    openvdb::CoordBBox box(openvdb::Coord::round(at), openvdb::Coord::round(at));
    box.expand(int(std::ceil(half + kHalfWidth)));
    for (auto c = box.begin(); c; ++c) {
      const double d = h * (((*c).asVec3d() - at).length() - half);
      if (d < background && d < values.getValue(*c)) values.setValueOn(*c, float(d));
    }
  }
  return grid;
}

}  // namespace slicemorph
