#include "engine/volume/surface_samples.h"

#include <algorithm>

namespace slicemorph {
namespace {

/// Strides of the even sequence in the plane: powers of 1 / 1.3247 [Rob18].
constexpr double kStrideU = 0.7548776662466927, kStrideV = 0.5698402909980532;

}  // namespace

std::vector<SurfacePoint> sampleSurface(const Mesh& mesh, const std::vector<std::uint32_t>& triangles,
                                        size_t count) {
  std::vector<double> upTo(triangles.size());  // area of the triangles up to and with each
  double area = 0;
  const auto corner = [&](size_t i, int k) { return Vec3d(mesh.points[mesh.triangles[triangles[i]][k]]); };
  for (size_t i = 0; i < triangles.size(); ++i) {
    const Vec3d a = corner(i, 0);
    upTo[i] = area += (corner(i, 1) - a).cross(corner(i, 2) - a).length() / 2;
  }
  std::vector<SurfacePoint> samples;
  if (!(area > 0)) return samples;
  samples.reserve(count);
  for (size_t k = 0; k < count; ++k) {
    const auto found = std::upper_bound(upTo.begin(), upTo.end(), area * (double(k) + 0.5) / double(count));
    if (found == upTo.end()) continue;
    const size_t i = size_t(found - upTo.begin());
    double u = evenSequence(k, kStrideU), v = evenSequence(k, kStrideV);
    if (u + v > 1) u = 1 - u, v = 1 - v;
    const Vec3d a = corner(i, 0), ab = corner(i, 1) - a, ac = corner(i, 2) - a;
    samples.push_back({a + u * ab + v * ac, ab.cross(ac).unit(), triangles[i]});
  }
  return samples;
}

}  // namespace slicemorph
