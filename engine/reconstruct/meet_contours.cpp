#include "engine/reconstruct/meet_contours.h"

#include <tbb/parallel_for.h>
#include <tbb/parallel_sort.h>

#include <algorithm>
#include <cmath>
#include <cstdint>
#include <utility>

namespace slicemorph {

namespace {

constexpr double kAllowed = 0.25;  // voxels that a contour point may be off; the header promises it
constexpr int kSweeps = 4;         // at most: moving the mesh to one point moves it off others

/// The point of a triangle nearest to p, in barycentric coordinates.
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
  Meeting(const ContourSet& set, double voxelSize, Mesh& mesh) : voxel_(voxelSize), mesh_(mesh) {
    for (const PlaneContours& plane : set.planes)
      for (const auto& loop : plane.loops)
        for (const Vec2d& p : loop) points_.push_back(plane.toWorld(p));
    near_.resize(points_.size());
    const std::vector<Binned> bins = binned();
    tbb::parallel_for(size_t(0), points_.size(),
                      [&](size_t i) { near_[i] = trianglesNear(points_[i], bins); });
  }

  /// Processes the points in order, so that the result is deterministic. Returns whether any point was too
  /// far off.
  bool sweep() {
    bool moved = false;
    for (size_t i = 0; i < points_.size(); ++i) moved |= pull(points_[i], near_[i]);
    return moved;
  }

 private:
  using Binned = std::pair<std::uint64_t, std::uint32_t>;  // key of a cell, triangle

  openvdb::Coord cellOf(const Vec3d& p) const { return openvdb::Coord::floor(p / voxel_); }

  /// A cell's key; keys ascend along x, then y, then z.
  static std::uint64_t keyOf(const openvdb::Coord& c) {
    constexpr int kBits = 21, kMiddle = 1 << (kBits - 1);
    std::uint64_t key = 0;
    for (int a : {2, 1, 0}) key = key << kBits | (std::uint64_t(c[a] + kMiddle) & ((1u << kBits) - 1));
    return key;
  }
  /// Each triangle in all cells that its box overlaps, ordered by cell.
  std::vector<Binned> binned() const {
    std::vector<Binned> bins;
    for (std::uint32_t t = 0; t < mesh_.triangles.size(); ++t) {
      openvdb::BBoxd box;
      for (int k = 0; k < 3; ++k) box.expand(Vec3d(mesh_.points[mesh_.triangles[t][k]]));
      const openvdb::CoordBBox cells(cellOf(box.min()), cellOf(box.max()));
      for (auto c = cells.begin(); c; ++c) bins.emplace_back(keyOf(*c), t);
    }
    tbb::parallel_sort(bins.begin(), bins.end());
    return bins;
  }
  std::vector<std::uint32_t> trianglesNear(const Vec3d& p, const std::vector<Binned>& bins) const {
    std::vector<std::uint32_t> near;
    const openvdb::Coord at = cellOf(p);
    for (int z : {-1, 0, 1})
      for (int y : {-1, 0, 1}) {
        const std::uint64_t last = keyOf(at.offsetBy(1, y, z));
        auto bin = std::lower_bound(bins.begin(), bins.end(), Binned(keyOf(at.offsetBy(-1, y, z)), 0));
        for (; bin != bins.end() && bin->first <= last; ++bin) near.push_back(bin->second);
      }
    std::sort(near.begin(), near.end());
    near.erase(std::unique(near.begin(), near.end()), near.end());
    return near;
  }
  bool pull(const Vec3d& p, const std::vector<std::uint32_t>& near) {
    double least = voxel_ * voxel_;
    std::uint32_t nearest = 0;
    Vec3d weights(0.0), off(0.0);
    bool found = false;
    for (std::uint32_t t : near) {
      const openvdb::Vec3I& v = mesh_.triangles[t];
      const Vec3d corners[3] = {Vec3d(mesh_.points[v[0]]), Vec3d(mesh_.points[v[1]]),
                                Vec3d(mesh_.points[v[2]])};
      const Vec3d w = nearestWeights(p, corners);
      const Vec3d d = p - (w[0] * corners[0] + w[1] * corners[1] + w[2] * corners[2]);
      if (d.lengthSqr() >= least) continue;
      least = d.lengthSqr(), nearest = t, weights = w, off = d, found = true;
    }
    if (!found || least <= kAllowed * kAllowed * voxel_ * voxel_) return false;
    const openvdb::Vec3I& v = mesh_.triangles[nearest];
    for (int k = 0; k < 3; ++k)
      mesh_.points[v[k]] +=
          openvdb::Vec3s(weights[k] / weights.lengthSqr() * (1 - kAllowed * voxel_ / std::sqrt(least)) * off);
    return true;
  }

  double voxel_;
  Mesh& mesh_;
  std::vector<Vec3d> points_;
  std::vector<std::vector<std::uint32_t>> near_;  // per point: the triangles near it before any was moved
};

}  // namespace

void meetContours(const ContourSet& set, double voxelSize, Mesh& mesh) {
  Meeting meeting(set, voxelSize, mesh);
  for (int sweep = 0; sweep < kSweeps && meeting.sweep(); ++sweep) {
  }
}

}  // namespace slicemorph
