#include "engine/volume/mesh_measures.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

openvdb::BBoxd boundsOf(const std::vector<openvdb::Vec3s>& points) {
  openvdb::BBoxd box;
  for (const openvdb::Vec3s& p : points) box.expand(Vec3d(p));
  return box;
}

double farthestCoordinate(const openvdb::BBoxd& box) {
  double farthest = 0;
  for (int i = 0; i < 3; ++i) farthest = std::max({farthest, std::abs(box.min()[i]), std::abs(box.max()[i])});
  return farthest;
}

double areaOf(const Mesh& mesh) {
  double twice = 0;
  for (const openvdb::Vec3I& t : mesh.triangles) {
    const Vec3d a(mesh.points[t[0]]);
    twice += (Vec3d(mesh.points[t[1]]) - a).cross(Vec3d(mesh.points[t[2]]) - a).length();
  }
  return twice / 2;
}

}  // namespace slicemorph
