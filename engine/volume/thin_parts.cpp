#include "engine/volume/thin_parts.h"

#include "engine/volume/mesh_measures.h"

#include <openvdb/tools/Interpolation.h>

#include <cmath>

namespace slicemorph {

namespace {

constexpr int kPoints = 20000;
/// Steps of a sequence that fills the square evenly, each part of it: powers of 1 over the plastic number.
constexpr double kStepU = 0.7548776662466927, kStepV = 0.5698402909980532;

double fractionOf(double x) { return x - std::floor(x); }

}  // namespace

double lostShare(const Mesh& mesh, const FloatGrid& levelSet) {
  const double each = areaOf(mesh) / kPoints, half = 0.5 * levelSet.voxelSize()[0];
  if (!(each > 0)) return 0;
  const auto accessor = levelSet.getConstAccessor();
  const auto isInside = [&](const Vec3d& p) {
    return openvdb::tools::BoxSampler::sample(accessor, levelSet.worldToIndex(p)) < 0;
  };
  double before = 0;  // area of the triangles so far
  int points = 0, lost = 0;
  for (const auto& t : mesh.triangles) {
    const Vec3d a(mesh.points[t[0]]), ab = Vec3d(mesh.points[t[1]]) - a, ac = Vec3d(mesh.points[t[2]]) - a;
    const Vec3d normal = ab.cross(ac);
    const double length = normal.length();
    before += 0.5 * length;
    // The points are `each` apart along the triangles' areas laid end to end.
    for (; (points + 0.5) * each < before; ++points) {
      double u = fractionOf(points * kStepU), v = fractionOf(points * kStepV);
      if (u + v > 1) u = 1 - u, v = 1 - v;
      const Vec3d p = a + u * ab + v * ac, off = normal * (half / length);
      lost += !isInside(p - off) && !isInside(p + off);
    }
  }
  return points > 0 ? double(lost) / points : 0;
}

}  // namespace slicemorph
