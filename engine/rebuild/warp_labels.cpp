#include "engine/rebuild/warp_labels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <limits>

namespace slicemorph {
namespace {

using openvdb::Vec3s;

ImageValues labelValues(std::int64_t most, size_t count) {
  if (most <= 255) return std::vector<std::uint8_t>(count);
  if (most <= 65535) return std::vector<std::uint16_t>(count);
  return std::vector<std::int32_t>(count);
}

/// Box of voxels of an object's image that encloses what a box of the in-between's voxels maps to.
openvdb::CoordBBox boxOf(const ImageNodes& nodes, size_t shape, const PositionToVoxel& toVoxel,
                         const openvdb::CoordBBox& box) {
  const openvdb::Vec3i& s = nodes.step;
  Vec3s low(std::numeric_limits<float>::max()), high(std::numeric_limits<float>::lowest());
  for (int k = box.min()[2] / s[2]; k <= box.max()[2] / s[2] + 1; ++k)
    for (int j = box.min()[1] / s[1]; j <= box.max()[1] / s[1] + 1; ++j)
      for (int i = box.min()[0] / s[0]; i <= box.max()[0] / s[0] + 1; ++i) {
        const Vec3s p = toVoxel(nodes.map.at[nodes.map.index(i, j, k) * nodes.map.objects + shape]);
        low = openvdb::math::minComponent(low, p), high = openvdb::math::maxComponent(high, p);
      }
  return {openvdb::Coord::floor(low), openvdb::Coord::ceil(high)};
}

/// The labels of all objects, and where each object has them.
struct SharedLabels {
  std::vector<std::int64_t> all;  ///< ascending
  std::vector<std::vector<const LabelField::Label*>>
      fieldOf;                                ///< per object and label; null: the object lacks it
  std::vector<std::vector<int>> sharedIndex;  ///< per object: index into `all` of each of its labels
  std::vector<float> absent;                  ///< per label: depth assumed in an object that lacks it
};

SharedLabels sharedLabels(const std::vector<CarriedLabels>& labels) {
  SharedLabels s;
  for (const CarriedLabels& c : labels)
    for (const LabelField::Label& l : c.labels->labels()) s.all.push_back(l.value);
  std::sort(s.all.begin(), s.all.end());
  s.all.erase(std::unique(s.all.begin(), s.all.end()), s.all.end());
  s.fieldOf.resize(labels.size()), s.sharedIndex.resize(labels.size());
  for (size_t c = 0; c < labels.size(); ++c) {
    for (std::int64_t value : s.all) s.fieldOf[c].push_back(labels[c].labels->find(value));
    for (const LabelField::Label& l : labels[c].labels->labels())
      s.sharedIndex[c].push_back(int(std::lower_bound(s.all.begin(), s.all.end(), l.value) - s.all.begin()));
  }
  // A label that an object lacks shrinks to nothing as the weight of that object grows.
  for (size_t l = 0; l < s.all.size(); ++l) {
    float deepest = 0, have = 0;
    for (size_t c = 0; c < labels.size(); ++c)
      if (s.fieldOf[c][l])
        deepest = std::max(deepest, s.fieldOf[c][l]->deepest), have += float(labels[c].weight);
    s.absent.push_back(-deepest * have);
  }
  return s;
}

/// Labels the in-between's voxels, block by block.
class BlockLabeller {
 public:
  BlockLabeller(const std::vector<CarriedLabels>& labels, const SharedLabels& shared,
                const std::vector<PositionToVoxel>& toVoxel, const ImageNodes& nodes)
      : labels_(labels), shared_(shared), toVoxel_(toVoxel), nodes_(nodes) {
    for (const CarriedLabels& c : labels) rows_.emplace_back(nodes, c.shape);
  }

  /// Calls `write(voxel, index into all labels)` for each voxel of the block that gets a label.
  template <typename Write>
  void label(const openvdb::CoordBBox& block, const Write& write) {
    findCandidates(block);
    if (candidates_.empty()) return;  // the result is 0 by default
    const openvdb::Coord first = block.min(), last = block.max();
    for (int k = first[2]; k <= last[2]; ++k)
      for (int j = first[1]; j <= last[1]; ++j) {
        for (PositionRow& row : rows_) row.begin(first[0], last[0], j, k);
        for (int i = first[0]; i <= last[0]; ++i)
          if (const int best = bestAt(i); best >= 0) write(openvdb::Coord(i, j, k), size_t(best));
      }
  }

 private:
  /// The labels that any object has near the block's image.
  void findCandidates(const openvdb::CoordBBox& block) {
    candidates_.clear();
    for (size_t c = 0; c < labels_.size(); ++c) {
      near_.clear();
      openvdb::CoordBBox box = boxOf(nodes_, labels_[c].shape, toVoxel_[c], block);
      box.expand(1);
      labels_[c].labels->labelsNear(box, near_);
      for (int l : near_) candidates_.push_back(shared_.sharedIndex[c][size_t(l)]);
    }
    std::sort(candidates_.begin(), candidates_.end());
    candidates_.erase(std::unique(candidates_.begin(), candidates_.end()), candidates_.end());
    blended_.resize(candidates_.size());
  }

  /// Label of voxel i of the row, as an index into all labels; -1: none.
  int bestAt(int i) {
    std::fill(blended_.begin(), blended_.end(), 0.f);
    float without = 0;
    for (size_t c = 0; c < labels_.size(); ++c) {
      const LabelField& field = *labels_[c].labels;
      const Vec3s p = toVoxel_[c](rows_[c].from(i).at);
      const float weight = float(labels_[c].weight);
      float most = field.depth(field.all(), p);
      for (size_t l = 0; l < candidates_.size(); ++l) {
        const size_t candidate = size_t(candidates_[l]);
        const LabelField::Label* own = shared_.fieldOf[c][candidate];
        const float depth = own ? field.depth(*own, p) : shared_.absent[candidate];
        if (!own) most = std::max(most, depth);
        blended_[l] += weight * depth;
      }
      without -= weight * most;
    }
    int best = -1;
    // Inside the union of all labels one of them wins, however shallow. Near borders that do not align on the
    // objects none is deep, and comparing with the unlabelled space would open a gap between them.
    float least = without < 0 ? std::numeric_limits<float>::lowest() : without;
    for (size_t l = 0; l < candidates_.size(); ++l)
      if (blended_[l] > least) least = blended_[l], best = candidates_[l];
    return best;
  }

  const std::vector<CarriedLabels>& labels_;
  const SharedLabels& shared_;
  const std::vector<PositionToVoxel>& toVoxel_;
  const ImageNodes& nodes_;
  std::vector<PositionRow> rows_;  ///< per object
  std::vector<int> near_, candidates_;
  std::vector<float> blended_;  ///< per candidate
};

}  // namespace

Image warpLabels(const std::vector<CarriedLabels>& labels, const ImageNodes& nodes, const ImageLattice& on) {
  const SharedLabels shared = sharedLabels(labels);
  std::vector<PositionToVoxel> toVoxel;
  toVoxel.reserve(labels.size());
  for (const CarriedLabels& c : labels) toVoxel.emplace_back(c.labels->lattice(), c.anchor);
  Image result{on, labelValues(shared.all.empty() ? 0 : shared.all.back(), on.count())};
  const auto write = [&](const openvdb::Coord& voxel, size_t label) {
    std::visit(
        [&](auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          values[on.index(voxel[0], voxel[1], voxel[2])] = T(shared.all[label]);
        },
        result.values);
  };
  constexpr int kBlock = 8;
  const openvdb::Coord blocks = (on.size + openvdb::Coord(kBlock - 1)) >> 3;
  tbb::parallel_for(0, blocks[2] * blocks[1], [&](int b) {
    BlockLabeller labeller(labels, shared, toVoxel, nodes);
    for (int i = 0; i < blocks[0]; ++i) {
      const openvdb::Coord first(i * kBlock, b % blocks[1] * kBlock, b / blocks[1] * kBlock);
      const openvdb::Coord end = openvdb::Coord::minComponent(first + openvdb::Coord(kBlock), on.size);
      labeller.label({first, end - openvdb::Coord(1)}, write);
    }
  });
  return result;
}

}  // namespace slicemorph
