#include "slicemorph/label_field.h"

#include "engine/numerics/distance_transform.h"
#include "engine/volume/image_shape.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <unordered_map>

namespace slicemorph {
namespace {

/// Voxels around a label that store distances; beyond them the distance to the box is subtracted.
constexpr int kLabelMargin = 3;
/// Side of the blocks of `inBlock_` in voxels; divisions by it are shifts by 3.
constexpr int kBlock = 8;

template <typename T>
std::vector<openvdb::CoordBBox> boxesOf(const ImageLattice& lattice, const std::vector<T>& values,
                                        const std::vector<LabelField::Label>& labels) {
  std::unordered_map<std::int64_t, size_t> index;
  for (size_t l = 0; l < labels.size(); ++l) index[labels[l].value] = l;
  std::vector<openvdb::CoordBBox> boxes(labels.size());
  size_t at = 0;
  for (int k = 0; k < lattice.size[2]; ++k)
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0];) {
        const T value = values[at];
        int end = i;
        for (; end < lattice.size[0] && values[at] == value; ++end) ++at;
        if (value != T(0)) {
          openvdb::CoordBBox& box = boxes[index[std::int64_t(value)]];
          box.expand(openvdb::Coord(i, j, k));
          box.expand(openvdb::Coord(end - 1, j, k));
        }
        i = end;
      }
  return boxes;
}

}  // namespace

LabelField::LabelField(const Image& image) : lattice_(image.lattice), spacing_(image.lattice.spacing()) {
  for (std::int64_t value : labelsOf(image)) labels_.push_back({value, {}, {}});
  blocks_ = (lattice_.size + openvdb::Coord(kBlock - 1)) >> 3;
  inBlock_.resize(size_t(blocks_[0]) * blocks_[1] * blocks_[2]);
  std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const std::vector<openvdb::CoordBBox> boxes = boxesOf(lattice_, values, labels_);
        const auto measure = [&](Label& label, const openvdb::CoordBBox& box, const auto& isInside) {
          label.box = box;
          label.box.expand(kLabelMargin);
          const openvdb::Coord size = label.box.dim(), first = label.box.min();
          std::vector<char> inside(size_t(size[0]) * size[1] * size[2], 0);
          for (int k = box.min()[2]; k <= box.max()[2]; ++k)
            for (int j = box.min()[1]; j <= box.max()[1]; ++j)
              for (int i = box.min()[0]; i <= box.max()[0]; ++i)
                inside[(size_t(k - first[2]) * size[1] + (j - first[1])) * size[0] + (i - first[0])] =
                    isInside(values[lattice_.index(i, j, k)]);
          label.distance = signedDistances(inside, size, lattice_.spacing());
          label.deepest = *std::max_element(label.distance.begin(), label.distance.end());
        };
        tbb::parallel_for(size_t(0), labels_.size(), [&](size_t l) {
          measure(labels_[l], boxes[l], [&](T v) { return v == T(labels_[l].value); });
        });
        openvdb::CoordBBox together;
        for (const openvdb::CoordBBox& box : boxes) together.expand(box);
        if (labels_.size() == 1)
          all_ = labels_[0];
        else if (!labels_.empty())
          measure(all_, together, [](T v) { return v != T(0); });
        for (size_t l = 0; l < labels_.size(); ++l) {
          const openvdb::CoordBBox& box = boxes[l];
          for (int k = box.min()[2]; k <= box.max()[2]; ++k)
            for (int j = box.min()[1]; j <= box.max()[1]; ++j)
              for (int i = box.min()[0]; i <= box.max()[0]; ++i) {
                if (values[lattice_.index(i, j, k)] != T(labels_[l].value)) continue;
                auto& list =
                    inBlock_[(size_t(k / kBlock) * blocks_[1] + j / kBlock) * blocks_[0] + i / kBlock];
                if (list.empty() || list.back() != int(l)) list.push_back(int(l));
              }
        }
      },
      image.values);
}

const LabelField::Label* LabelField::find(std::int64_t value) const {
  const auto at = std::lower_bound(labels_.begin(), labels_.end(), value,
                                   [](const Label& label, std::int64_t v) { return label.value < v; });
  return at != labels_.end() && at->value == value ? &*at : nullptr;
}

float LabelField::depth(const Label& label, const openvdb::Vec3f& voxel) const {
  const openvdb::Coord size = label.box.dim(), first = label.box.min();
  float away = 0, f[3];
  int at[3];
  for (int d = 0; d < 3; ++d) {
    const float p = voxel[d] - float(first[d]), inBox = std::min(std::max(p, 0.f), float(size[d] - 1));
    const float off = (p - inBox) * spacing_[d];
    away += off * off;
    at[d] = std::min(int(inBox), size[d] - 2);
    f[d] = inBox - float(at[d]);
  }
  const float* v = &label.distance[(size_t(at[2]) * size[1] + at[1]) * size[0] + at[0]];
  const size_t y = size_t(size[0]), z = y * size_t(size[1]);
  const auto line = [&](const float* p) { return p[0] + f[0] * (p[1] - p[0]); };
  const float a = line(v) + f[1] * (line(v + y) - line(v)),
              b = line(v + z) + f[1] * (line(v + z + y) - line(v + z));
  const float inside = a + f[2] * (b - a);
  return away > 0 ? std::min(inside, 0.f) - std::sqrt(away) : inside;
}

void LabelField::labelsNear(const openvdb::CoordBBox& box, std::vector<int>& found) const {
  openvdb::Coord low = box.min() >> 3, high = box.max() >> 3;
  low.maxComponent(openvdb::Coord(0));
  high.minComponent(blocks_ - openvdb::Coord(1));
  for (int k = low[2]; k <= high[2]; ++k)
    for (int j = low[1]; j <= high[1]; ++j)
      for (int i = low[0]; i <= high[0]; ++i) {
        const auto& list = inBlock_[(size_t(k) * blocks_[1] + j) * blocks_[0] + i];
        found.insert(found.end(), list.begin(), list.end());
      }
  std::sort(found.begin(), found.end());
  found.erase(std::unique(found.begin(), found.end()), found.end());
}

}  // namespace slicemorph
