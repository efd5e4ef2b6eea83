#include "engine/reconstruct/specks.h"

#include "engine/numerics/disjoint_sets.h"

#include <cmath>
#include <map>

namespace slicemorph {

namespace {

class Specks {
 public:
  Specks(const Mesh& mesh, double voxelSize) : mesh_(mesh), voxel_(voxelSize), shells_(mesh.points.size()) {
    for (const openvdb::Vec3I& t : mesh.triangles)
      for (int k = 1; k < 3; ++k) shells_.join(t[k], t[0]);
    std::map<std::uint32_t, double> volumes;
    for (const openvdb::Vec3I& t : mesh.triangles) {
      const std::uint32_t shell = shellOf(t[0]);
      const Vec3d o(mesh.points[shell]), a = Vec3d(mesh.points[t[0]]) - o;
      const Vec3d b = Vec3d(mesh.points[t[1]]) - o, c = Vec3d(mesh.points[t[2]]) - o;
      volumes[shell] += a.dot(b.cross(c)) / 6;
    }
    for (const auto& [shell, volume] : volumes)
      if (std::abs(volume) < std::pow(voxelSize, 3)) specks_[shell];
    for (std::uint32_t p = 0; p < mesh.points.size(); ++p)
      if (const auto speck = specks_.find(shellOf(p)); speck != specks_.end())
        speck->second.expand(Vec3d(mesh.points[p]));
  }

  Mesh without(const ContourSet& set) {
    if (specks_.empty()) return mesh_;
    for (const PlaneContours& plane : set.planes)
      for (const auto& loop : plane.loops)
        for (const Vec2d& p : loop) keepFor(plane.toWorld(p));
    Mesh out;
    std::vector<std::uint32_t> index(mesh_.points.size());
    for (std::uint32_t p = 0; p < mesh_.points.size(); ++p) {
      if (specks_.count(shellOf(p))) continue;
      index[p] = std::uint32_t(out.points.size());
      out.points.push_back(mesh_.points[p]);
    }
    for (const openvdb::Vec3I& t : mesh_.triangles)
      if (!specks_.count(shellOf(t[0]))) out.triangles.emplace_back(index[t[0]], index[t[1]], index[t[2]]);
    return out;
  }

 private:
  std::uint32_t shellOf(std::uint32_t p) { return shells_.find(p); }
  /// Keeps the specks around a contour point to which nothing else is within a voxel.
  void keepFor(const Vec3d& p) {
    std::vector<std::uint32_t> around;
    for (const auto& [shell, box] : specks_)
      if (openvdb::BBoxd(box.min() - Vec3d(voxel_), box.max() + Vec3d(voxel_)).isInside(p))
        around.push_back(shell);
    if (around.empty()) return;
    for (std::uint32_t q = 0; q < mesh_.points.size(); ++q)
      if ((Vec3d(mesh_.points[q]) - p).lengthSqr() < voxel_ * voxel_ && !specks_.count(shellOf(q))) return;
    for (std::uint32_t shell : around) specks_.erase(shell);
  }

  const Mesh& mesh_;
  double voxel_;
  DisjointSets shells_;                             ///< of connected points
  std::map<std::uint32_t, openvdb::BBoxd> specks_;  ///< box of each speck's shell
};

}  // namespace

Mesh withoutSpecks(const Mesh& mesh, const ContourSet& set, double voxelSize) {
  return Specks(mesh, voxelSize).without(set);
}

}  // namespace slicemorph
