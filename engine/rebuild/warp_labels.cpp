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

/// Box of an image's voxels around all that a box of the in-between's voxels lies on.
openvdb::CoordBBox boxOf(const ImageNodes& nodes, size_t shape, const PlaceToVoxel& toVoxel,
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

}  // namespace

Image warpLabels(const std::vector<CarriedLabels>& labels, const ImageNodes& nodes, const ImageLattice& on) {
  std::vector<PlaceToVoxel> toVoxel;
  std::vector<std::int64_t> all;
  for (const CarriedLabels& c : labels) {
    toVoxel.emplace_back(c.labels->lattice(), c.anchor);
    for (const LabelField::Label& l : c.labels->labels()) all.push_back(l.value);
  }
  std::sort(all.begin(), all.end());
  all.erase(std::unique(all.begin(), all.end()), all.end());
  // Each label's field in every object; null where it lacks the label.
  std::vector<std::vector<const LabelField::Label*>> fieldOf(labels.size());
  std::vector<std::vector<int>> placeOf(labels.size());  // index into `all` of the object's own labels
  for (size_t c = 0; c < labels.size(); ++c) {
    for (std::int64_t value : all) fieldOf[c].push_back(labels[c].labels->find(value));
    for (const LabelField::Label& l : labels[c].labels->labels())
      placeOf[c].push_back(int(std::lower_bound(all.begin(), all.end(), l.value) - all.begin()));
  }
  // A label that an object lacks shrinks to nothing as that object takes over.
  std::vector<float> absent(all.size(), 0);
  for (size_t l = 0; l < all.size(); ++l) {
    float deepest = 0, have = 0;
    for (size_t c = 0; c < labels.size(); ++c)
      if (fieldOf[c][l]) deepest = std::max(deepest, fieldOf[c][l]->deepest), have += float(labels[c].weight);
    absent[l] = -deepest * have;
  }
  Image result{on, labelValues(all.empty() ? 0 : all.back(), on.count())};
  constexpr int kBlock = 8;
  const openvdb::Coord blocks = (on.size + openvdb::Coord(kBlock - 1)) >> 3;
  tbb::parallel_for(0, blocks[2] * blocks[1], [&](int b) {
    std::vector<int> near, candidates;
    std::vector<float> blended;
    std::vector<PlaceRow> rows;
    for (const CarriedLabels& c : labels) rows.emplace_back(nodes, c.shape);
    for (int bi = 0; bi < blocks[0]; ++bi) {
      const openvdb::Coord first(bi * kBlock, b % blocks[1] * kBlock, b / blocks[1] * kBlock);
      const openvdb::Coord end = openvdb::Coord::minComponent(first + openvdb::Coord(kBlock), on.size);
      candidates.clear();
      for (size_t c = 0; c < labels.size(); ++c) {
        near.clear();
        openvdb::CoordBBox box = boxOf(nodes, labels[c].shape, toVoxel[c], {first, end - openvdb::Coord(1)});
        box.expand(1);
        labels[c].labels->labelsNear(box, near);
        for (int l : near) candidates.push_back(placeOf[c][size_t(l)]);
      }
      if (candidates.empty()) continue;  // 0 as it is
      std::sort(candidates.begin(), candidates.end());
      candidates.erase(std::unique(candidates.begin(), candidates.end()), candidates.end());
      blended.resize(candidates.size());
      for (int k = first[2]; k < end[2]; ++k)
        for (int j = first[1]; j < end[1]; ++j) {
          for (PlaceRow& row : rows) row.begin(first[0], end[0] - 1, j, k);
          for (int i = first[0]; i < end[0]; ++i) {
            std::fill(blended.begin(), blended.end(), 0.f);
            float without = 0;
            for (size_t c = 0; c < labels.size(); ++c) {
              const openvdb::Vec3s p = toVoxel[c](rows[c].from(i).at);
              const float weight = float(labels[c].weight);
              float most = labels[c].labels->depth(labels[c].labels->all(), p);
              for (size_t l = 0; l < candidates.size(); ++l) {
                const LabelField::Label* field = fieldOf[c][size_t(candidates[l])];
                const float depth =
                    field ? labels[c].labels->depth(*field, p) : absent[size_t(candidates[l])];
                if (!field) most = std::max(most, depth);
                blended[l] += weight * depth;
              }
              without -= weight * most;
            }
            int best = -1;
            float least = without;
            for (size_t l = 0; l < candidates.size(); ++l)
              if (blended[l] > least) least = blended[l], best = candidates[l];
            if (best >= 0)
              std::visit(
                  [&](auto& values) {
                    using T = typename std::decay_t<decltype(values)>::value_type;
                    values[on.index(i, j, k)] = T(all[size_t(best)]);
                  },
                  result.values);
          }
        }
    }
  });
  return result;
}

}  // namespace slicemorph
