#include "engine/rebuild/rebuild.h"

#include "engine/blend/node_positions.h"
#include "engine/rebuild/redistance.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {

namespace {

/// As kSteepest, a bound on the gradient of the blended distance, for weights that vary in space: their own
/// gradient, times the difference of the objects' distances, adds to it. Allows twice the constant case.
constexpr double kSteepestWhereVarying = 2.6;

class Rebuilder {
 public:
  Rebuilder(const NodeMap& nodes, const Fields& fields, const DistanceBlend& blend,
            const openvdb::math::Transform& transform)
      : nodes_(nodes),
        voxel_(transform.voxelSize()[0]),
        step_(nodes.step),
        steepest_(blend.weights.vary() ? kSteepestWhereVarying : kSteepest),
        positions_(nodes),
        blend_(blend),
        used_(blend.weights.used()) {
    for (size_t k : used_) {
      factor_.push_back(float(blend.weights.whole()[k] * blend.size / blend.sizes[k]));
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
  /// Buffers of one task, used where weights vary.
  struct Local {
    std::vector<openvdb::Vec3s> at;  ///< per object
    Weights weights;                 ///< per object
    std::vector<float> factors;      ///< per used object
  };

  /// Factors of the used objects' distances at a point; `at` holds its position on every object.
  const float* factorsAt(const openvdb::Vec3s* at, Local& local) const {
    if (!blend_.weights.vary()) return factor_.data();
    local.weights.resize(blend_.sizes.size()), local.factors.resize(used_.size());
    blend_.weights.find(at, local.weights.data());
    double size = 0;
    for (size_t k = 0; k < local.weights.size(); ++k) size += local.weights[k] * blend_.sizes[k];
    for (size_t n = 0; n < used_.size(); ++n)
      local.factors[n] = float(local.weights[used_[n]] * size / blend_.sizes[used_[n]]);
    return local.factors.data();
  }

  /// The same half way between voxels a and b of a cell; `positions` per used object and voxel.
  const float* factorsOf(const std::vector<std::vector<openvdb::Vec3s>>& positions, size_t a, size_t b,
                         Local& local) const {
    if (!blend_.weights.vary()) return factor_.data();
    local.at.resize(blend_.sizes.size());
    for (size_t n = 0; n < used_.size(); ++n) local.at[used_[n]] = (positions[n][a] + positions[n][b]) * 0.5f;
    return factorsAt(local.at.data(), local);
  }

  void findNodeDistances() {
    distance_.assign(nodes_.known.size(), std::numeric_limits<float>::max());
    tbb::parallel_for(0, int(nodes_.size[2]), [&](int z) {
      const size_t slab = size_t(nodes_.size[0]) * nodes_.size[1];
      Local local;
      for (size_t i = z * slab; i < (z + 1) * slab; ++i) {
        if (!nodes_.known[i]) continue;
        const openvdb::Vec3s* at = &nodes_.at[i * nodes_.objects];
        const float* factors = factorsAt(at, local);
        float d = 0;
        for (size_t n = 0; n < used_.size(); ++n) d += factors[n] * samplers_[n].coarse(at[used_[n]]);
        distance_[i] = d;
      }
    });
  }

  /// Whether the cell with this first node may contain voxels of the narrow band. A point of the cell is at
  /// most half its diagonal away from a node.
  bool cellActive(int i, int j, int k) const {
    if (!nodes_.inside(i, j, k) || !nodes_.inside(i + 1, j + 1, k + 1)) return false;
    float least = std::numeric_limits<float>::max();
    for (int c = 0; c < 8; ++c) {
      const size_t n = nodes_.index(i + (c & 1), j + (c >> 1 & 1), k + (c >> 2));
      if (!nodes_.known[n]) return false;
      least = std::min(least, std::abs(distance_[n]));
    }
    return least < (kHalfWidth + steepest_ * 0.5 * std::sqrt(3.0) * step_) * voxel_;
  }

  void fillLeaf(const openvdb::Coord& origin, float* values) const {
    std::vector<std::vector<openvdb::Vec3s>> positions(
        used_.size(), std::vector<openvdb::Vec3s>(size_t(step_) * step_ * step_));
    for (int z = 0; z < kLeaf; z += step_)
      for (int y = 0; y < kLeaf; y += step_)
        for (int x = 0; x < kLeaf; x += step_) {
          const int i = (origin[0] + x) / step_, j = (origin[1] + y) / step_, k = (origin[2] + z) / step_;
          if (cellActive(i, j, k)) fillCell(i, j, k, positions, values + (x * kLeaf + y) * kLeaf + z);
        }
  }

  /// `values` points to the cell's first voxel within a leaf (x slowest). Voxels are processed in blocks of 2
  /// x 2 x 2; a block is sampled only if its centre is close enough to the surface for the block to contain a
  /// voxel of the band. Otherwise its voxels get the centre's value.
  void fillCell(int i, int j, int k, std::vector<std::vector<openvdb::Vec3s>>& positions,
                float* values) const {
    for (size_t n = 0; n < used_.size(); ++n) {
      if (positions_.torn(i, j, k, 2, used_[n])) return blendNodes(i, j, k, values);
      positions_.find(i, j, k, used_[n], positions[n]);
    }
    Local local;
    const float far = float((kHalfWidth + 1 + steepest_ * 0.5 * std::sqrt(3.0)) * voxel_);
    for (int x = 0; x < step_; x += 2)
      for (int y = 0; y < step_; y += 2)
        for (int z = 0; z < step_; z += 2) {
          const size_t first = (size_t(x) * step_ + y) * step_ + z;
          const size_t last = first + (size_t(step_) + 1) * step_ + 1;
          const float* factors = factorsOf(positions, first, last, local);
          float middle = 0;
          for (size_t n = 0; n < used_.size(); ++n)
            middle += factors[n] * samplers_[n].coarse((positions[n][first] + positions[n][last]) * 0.5f);
          const bool near = std::abs(middle) < far;
          for (int v = 0; v < 8; ++v) {
            const int dx = v >> 2, dy = v >> 1 & 1, dz = v & 1;
            float f = middle;
            if (near) {
              f = 0;
              const size_t index = first + (size_t(dx) * step_ + dy) * step_ + dz;
              const float* own = factorsOf(positions, index, index, local);
              for (size_t n = 0; n < used_.size(); ++n) f += own[n] * samplers_[n](positions[n][index]);
            }
            values[((x + dx) * kLeaf + y + dy) * kLeaf + z + dz] = f;
          }
        }
  }

  /// Where slices cross the map is undefined between nodes, so the nodes' own distances are interpolated.
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
  double steepest_;
  NodePositions positions_;
  const DistanceBlend& blend_;
  std::vector<size_t> used_;   ///< objects with a weight other than 0 somewhere
  std::vector<float> factor_;  ///< per used object, where weights do not vary
  std::vector<DistanceField::Sampler> samplers_;
  std::vector<float> distance_;  ///< blended distance per node, world units
};

}  // namespace

FloatGrid::Ptr rebuildLevelSet(const NodeMap& nodes, const Fields& fields, const DistanceBlend& blend,
                               const openvdb::math::Transform& transform) {
  return redistance(Rebuilder(nodes, fields, blend, transform).run(), transform);
}

}  // namespace slicemorph
