#include "engine/reconstruct/meet_contours.h"

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace slicemorph {

namespace {

constexpr double kAllowed = 0.25;  // voxels
constexpr int kSweeps = 4;

/// The place of a triangle nearest to a point, as weights of its corners.
Vec3d nearestWeights(const Vec3d& p, const Vec3d (&t)[3]) {
  const Vec3d normal = (t[1] - t[0]).cross(t[2] - t[0]);
  const double area = normal.lengthSqr();
  if (area > 0) {
    Vec3d w;
    for (int k = 0; k < 3; ++k) {
      const Vec3d &b = t[(k + 1) % 3], &c = t[(k + 2) % 3];
      w[k] = (c - b).cross(p - b).dot(normal) / area;
    }
    if (w[0] >= 0 && w[1] >= 0 && w[2] >= 0) return w;
  }
  Vec3d best(1, 0, 0);
  double least = 1e300;
  for (int k = 0; k < 3; ++k) {
    const Vec3d d = t[(k + 1) % 3] - t[k];
    const double l = d.lengthSqr(), s = l > 0 ? std::clamp((p - t[k]).dot(d) / l, 0.0, 1.0) : 0;
    const double off = (p - t[k] - s * d).lengthSqr();
    if (off >= least) continue;
    least = off;
    best = Vec3d(0.0);
    best[k] = 1 - s;
    best[(k + 1) % 3] = s;
  }
  return best;
}

class Meeting {
 public:
  Meeting(double voxelSize, Mesh& mesh) : voxel_(voxelSize), mesh_(mesh) {
    for (std::uint32_t t = 0; t < mesh.triangles.size(); ++t) {
      openvdb::BBoxd box;
      for (int k = 0; k < 3; ++k) box.expand(Vec3d(mesh.points[mesh.triangles[t][k]]));
      const openvdb::CoordBBox cells(cellOf(box.min()), cellOf(box.max()));
      for (auto c = cells.begin(); c; ++c) bins_[*c].push_back(t);
    }
  }

  /// In the order of the points: the result does not depend on anything else.
  void pull(const Vec3d& p) {
    const openvdb::Coord at = cellOf(p);
    double least = voxel_ * voxel_;
    std::uint32_t nearest = 0;
    Vec3d weights(0.0), off(0.0);
    bool found = false;
    const openvdb::CoordBBox around(at.offsetBy(-1), at.offsetBy(1));
    for (auto c = around.begin(); c; ++c) {
      const auto bin = bins_.find(*c);
      if (bin == bins_.end()) continue;
      for (std::uint32_t t : bin->second) {
        const openvdb::Vec3I& v = mesh_.triangles[t];
        const Vec3d corners[3] = {Vec3d(mesh_.points[v[0]]), Vec3d(mesh_.points[v[1]]), Vec3d(mesh_.points[v[2]])};
        const Vec3d w = nearestWeights(p, corners);
        const Vec3d d = p - (w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2]);
        if (d.lengthSqr() >= least) continue;
        least = d.lengthSqr(), nearest = t, weights = w, off = d, found = true;
      }
    }
    if (!found || least <= kAllowed * kAllowed * voxel_ * voxel_) return;
    const openvdb::Vec3I& v = mesh_.triangles[nearest];
    for (int k = 0; k < 3; ++k)
      mesh_.points[v[k]] += openvdb::Vec3s(weights[k] / weights.lengthSqr() * (1 - kAllowed * voxel_ / std::sqrt(least)) * off);
  }

 private:
  openvdb::Coord cellOf(const Vec3d& p) const { return openvdb::Coord::floor(p / voxel_); }

  double voxel_;
  Mesh& mesh_;
  std::unordered_map<openvdb::Coord, std::vector<std::uint32_t>> bins_;
};

}  // namespace

void meetContours(const ContourSet& set, double voxelSize, Mesh& mesh) {
  Meeting meeting(voxelSize, mesh);
  for (int sweep = 0; sweep < kSweeps; ++sweep)
    for (const PlaneContours& plane : set.planes)
      for (const auto& loop : plane.loops)
        for (const Vec2d& p : loop) meeting.pull(plane.toWorld(p));
}

}  // namespace slicemorph
