#include "io/mesh/vertex_normals.h"

namespace slicemorph {

std::vector<openvdb::Vec3s> vertexNormals(const std::vector<openvdb::Vec3I>& triangles,
                                          const std::vector<openvdb::Vec3s>& points,
                                          const std::vector<openvdb::Vec3s>* instead) {
  std::vector<Vec3d> sums(points.size(), Vec3d(0.0));
  for (const openvdb::Vec3I& t : triangles) {
    const Vec3d a(points[t[0]]), b(points[t[1]]), c(points[t[2]]);
    const Vec3d normal = (b - a).cross(c - a);
    for (int i = 0; i < 3; ++i) sums[t[i]] += normal;
  }
  std::vector<openvdb::Vec3s> normals(points.size());
  for (size_t i = 0; i < points.size(); ++i)
    normals[i] = sums[i].normalize(0.0) ? openvdb::Vec3s(sums[i])
                 : instead              ? (*instead)[i]
                                        : openvdb::Vec3s(0, 0, 1);
  return normals;
}

}  // namespace slicemorph
