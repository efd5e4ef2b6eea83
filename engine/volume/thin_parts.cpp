#include "engine/volume/thin_parts.h"

#include "engine/volume/surface_samples.h"

#include <openvdb/tools/Interpolation.h>

#include <algorithm>
#include <numeric>

namespace slicemorph {

double lostShare(const Mesh& mesh, const FloatGrid& levelSet) {
  constexpr size_t kPoints = 20000;
  std::vector<std::uint32_t> all(mesh.triangles.size());
  std::iota(all.begin(), all.end(), 0);
  const std::vector<SurfacePoint> points = sampleSurface(mesh, all, kPoints);
  if (points.empty()) return 0;
  const double half = 0.5 * levelSet.voxelSize()[0];
  const auto accessor = levelSet.getConstAccessor();
  const auto isInside = [&](const Vec3d& p) {
    return openvdb::tools::BoxSampler::sample(accessor, levelSet.worldToIndex(p)) < 0;
  };
  const auto lost = std::count_if(points.begin(), points.end(), [&](const SurfacePoint& s) {
    return !isInside(s.point - half * s.normal) && !isInside(s.point + half * s.normal);
  });
  return double(lost) / double(points.size());
}

}  // namespace slicemorph
