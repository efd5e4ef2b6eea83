#include "engine/rebuild/rebuild.h"

#include "engine/blend/node_places.h"
#include "engine/rebuild/redistance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

class Rebuilder {
 public:
  Rebuilder(const NodeMap& nodes, const Fields& fields, const std::vector<double>& factors,
            const openvdb::math::Transform& transform)
      : nodes_(nodes), voxel_(transform.voxelSize()[0]), step_(nodes.step), places_(nodes) {
    for (size_t k = 0; k < factors.size(); ++k)
      if (factors[k] > 0) {
        used_.push_back(k);
        factor_.push_back(float(factors[k]));
        samplers_.emplace_back(*fields[k]);
      }
  }

  SparseValues run() {
    findNodeDistances();
    const std::vector<openvdb::Coord> origins =
        leavesWith(nodes_, [this](int i, int j, int k) { return cellActive(i, j, k); });
    SparseValues values(origins, float(voxel_));
    tbb::parallel_for(size_t(0), origins.size(), [&](size_t i) { fillLeaf(origins[i], values.leaf(i)); });
    return values;
  }

 private:
  void findNodeDistances() {
    distance_.assign(nodes_.known.size(), std::numeric_limits<float>::max());
    tbb::parallel_for(0, int(nodes_.size[2]), [&](int z) {
      const size_t slab = size_t(nodes_.size[0]) * nodes_.size[1];
      for (size_t i = z * slab; i < (z + 1) * slab; ++i) {
        if (!nodes_.known[i]) continue;
        float d = 0;
        for (size_t n = 0; n < used_.size(); ++n) {
          const size_t k = used_[n];
          d += factor_[n] * samplers_[n].coarse(nodes_.at[i * nodes_.objects + k]);
        }
        distance_[i] = d;
      }
    });
  }

  /// Whether the cell with this first node may hold voxels of the band.
  bool cellActive(int i, int j, int k) const {
    if (!nodes_.inside(i, j, k) || !nodes_.inside(i + 1, j + 1, k + 1)) return false;
    float least = std::numeric_limits<float>::max();
    for (int c = 0; c < 8; ++c) {
      const size_t n = nodes_.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
      if (!nodes_.known[n]) return false;
      least = std::min(least, std::abs(distance_[n]));
    }
    return least < (kHalfWidth + kSteepest * 0.5 * std::sqrt(3.0) * step_) * voxel_;
  }

  void fillLeaf(const openvdb::Coord& origin, float* values) const {
    std::vector<std::vector<openvdb::Vec3s>> places(
        used_.size(), std::vector<openvdb::Vec3s>(size_t(step_) * step_ * step_));
    for (int z = 0; z < kLeaf; z += step_)
      for (int y = 0; y < kLeaf; y += step_)
        for (int x = 0; x < kLeaf; x += step_) {
          const int i = (origin[0] + x) / step_, j = (origin[1] + y) / step_, k = (origin[2] + z) / step_;
          if (cellActive(i, j, k)) fillCell(i, j, k, places, values + (x * kLeaf + y) * kLeaf + z);
        }
  }

  /// `values`: of the cell's first voxel, in OpenVDB's leaf order (x slowest). Voxels go by blocks of 2 x 2 x 2, and
  /// only those blocks are sampled whose middle is near enough to the surface to hold a voxel of the band.
  void fillCell(int i, int j, int k, std::vector<std::vector<openvdb::Vec3s>>& places, float* values) const {
    for (size_t n = 0; n < used_.size(); ++n) {
      if (places_.torn(i, j, k, 2, used_[n])) return blendNodes(i, j, k, values);
      places_.find(i, j, k, used_[n], places[n]);
    }
    const float far = float((kHalfWidth + 1 + kSteepest * 0.5 * std::sqrt(3.0)) * voxel_);
    for (int x = 0; x < step_; x += 2)
      for (int y = 0; y < step_; y += 2)
        for (int z = 0; z < step_; z += 2) {
          const size_t first = (size_t(x) * step_ + y) * step_ + z;
          const size_t last = first + (size_t(step_) + 1) * step_ + 1;
          float middle = 0;
          for (size_t n = 0; n < used_.size(); ++n)
            middle += factor_[n] * samplers_[n].coarse((places[n][first] + places[n][last]) * 0.5f);
          const bool near = std::abs(middle) < far;
          for (int v = 0; v < 8; ++v) {
            const int dx = v >> 2, dy = v >> 1 & 1, dz = v & 1;
            float f = middle;
            if (near) {
              f = 0;
              const size_t place = first + (size_t(dx) * step_ + dy) * step_ + dz;
              for (size_t n = 0; n < used_.size(); ++n) f += factor_[n] * samplers_[n](places[n][place]);
            }
            values[((x + dx) * kLeaf + y + dy) * kLeaf + z + dz] = f;
          }
        }
  }

  /// A cell between crossing slices takes its nodes' own distances.
  void blendNodes(int i, int j, int k, float* values) const {
    for (int x = 0; x < step_; ++x)
      for (int y = 0; y < step_; ++y)
        for (int z = 0; z < step_; ++z) {
          const float a = float(x) / step_, b = float(y) / step_, c = float(z) / step_;
          float sum = 0;
          for (int n = 0; n < 8; ++n)
            sum += distance_[nodes_.index(i + (n & 1), j + (n >> 1 & 1), k + (n >> 2))] *
                   ((n & 1 ? a : 1 - a) * (n & 2 ? b : 1 - b) * (n & 4 ? c : 1 - c));
          values[(x * kLeaf + y) * kLeaf + z] = sum;
        }
  }

  const NodeMap& nodes_;
  double voxel_;
  int step_;
  NodePlaces places_;
  std::vector<DistanceField::Sampler> samplers_;
  std::vector<size_t> used_;    ///< objects of positive factor
  std::vector<float> factor_;   ///< of each of these
  std::vector<float> distance_; ///< blended, per node, world units
};

}  // namespace

FloatGrid::Ptr rebuildLevelSet(const NodeMap& nodes, const Fields& fields, const std::vector<double>& factors,
                               const openvdb::math::Transform& transform) {
  return redistance(Rebuilder(nodes, fields, factors, transform).run(), transform);
}

}  // namespace slicemorph
