#include "engine/measure/label_comparison.h"

#include "engine/numerics/distance_transform.h"
#include "engine/numerics/percentile.h"
#include "slicemorph/errors.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <numeric>

namespace slicemorph {
namespace {

struct LabelTally {
  size_t voxels[2] = {0, 0}, shared = 0;
  Vec3d sum[2] = {Vec3d(0.0), Vec3d(0.0)};
  openvdb::CoordBBox box;  ///< of both

  void add(const LabelTally& other) {
    for (int m = 0; m < 2; ++m) voxels[m] += other.voxels[m], sum[m] += other.sum[m];
    shared += other.shared;
    box.expand(other.box);
  }
};

/// `value(map, index)`: the label of a voxel.
template <typename Value>
std::map<std::int64_t, LabelTally> tallyBoth(const ImageLattice& lattice, const Value& value) {
  std::vector<std::map<std::int64_t, LabelTally>> slices{size_t(lattice.size[2])};
  tbb::parallel_for(0, lattice.size[2], [&](int k) {
    for (int j = 0; j < lattice.size[1]; ++j)
      for (int i = 0; i < lattice.size[0]; ++i) {
        const size_t at = lattice.index(i, j, k);
        const std::int64_t labels[2] = {value(0, at), value(1, at)};
        for (int m = 0; m < 2; ++m) {
          if (labels[m] == 0) continue;
          LabelTally& tally = slices[size_t(k)][labels[m]];
          ++tally.voxels[m];
          tally.sum[m] += Vec3d(i, j, k);
          tally.box.expand(openvdb::Coord(i, j, k));
          if (m == 0 && labels[1] == labels[0]) ++tally.shared;
        }
      }
  });
  std::map<std::int64_t, LabelTally> all;
  for (const auto& slice : slices)
    for (const auto& [label, tally] : slice) all[label].add(tally);
  return all;
}

/// One label of one map within a box of voxels.
struct LabelBox {
  openvdb::CoordBBox box;
  openvdb::Coord size;
  size_t index(int i, int j, int k) const {
    return (size_t(k) * size_t(size[1]) + size_t(j)) * size_t(size[0]) + size_t(i);
  }
  size_t count() const { return size_t(size[0]) * size_t(size[1]) * size_t(size[2]); }
};

/// The voxels of a mask that have a neighbour over a face outside of it.
std::vector<char> outerVoxels(const std::vector<char>& mask, const LabelBox& in) {
  std::vector<char> outer(mask.size(), 0);
  const openvdb::Coord n = in.size;
  tbb::parallel_for(0, n[2], [&](int k) {
    const auto has = [&](int i, int j, int l) {
      return i >= 0 && j >= 0 && l >= 0 && i < n[0] && j < n[1] && l < n[2] && mask[in.index(i, j, l)];
    };
    for (int j = 0; j < n[1]; ++j)
      for (int i = 0; i < n[0]; ++i)
        outer[in.index(i, j, k)] =
            has(i, j, k) && !(has(i - 1, j, k) && has(i + 1, j, k) && has(i, j - 1, k) && has(i, j + 1, k) &&
                              has(i, j, k - 1) && has(i, j, k + 1));
  });
  return outer;
}

/// Adds the distances of one surface's voxels to the nearest one of the other.
void addDistances(const std::vector<char>& from, const std::vector<char>& to, const LabelBox& in,
                  const Vec3d& spacing, std::vector<float>& distances) {
  const std::vector<float> field = signedDistances(to, in.size, spacing);
  for (size_t i = 0; i < from.size(); ++i)
    if (from[i]) distances.push_back(to[i] ? 0.f : std::abs(field[i]));
}

template <typename Value>
SurfaceDistance distanceOfLabel(const ImageLattice& lattice, const Value& value, std::int64_t label,
                                const openvdb::CoordBBox& box) {
  const LabelBox in{box, box.dim()};
  std::vector<char> outer[2];
  for (int m = 0; m < 2; ++m) {
    std::vector<char> mask(in.count());
    tbb::parallel_for(0, in.size[2], [&](int k) {
      for (int j = 0; j < in.size[1]; ++j)
        for (int i = 0; i < in.size[0]; ++i)
          mask[in.index(i, j, k)] =
              value(m, lattice.index(box.min()[0] + i, box.min()[1] + j, box.min()[2] + k)) == label;
    });
    outer[m] = outerVoxels(mask, in);
  }
  std::vector<float> distances;
  for (int m = 0; m < 2; ++m) addDistances(outer[m], outer[1 - m], in, lattice.spacing(), distances);
  SurfaceDistance result;
  result.mean = std::accumulate(distances.begin(), distances.end(), 0.0) / double(distances.size());
  result.p95 = percentileOf(distances, 0.95), result.p99 = percentileOf(distances, 0.99);
  result.max = *std::max_element(distances.begin(), distances.end());
  return result;
}

void refuseLeaning(const ImageLattice& lattice) {
  constexpr double kRightAngle = 1e-4;  // cosine
  for (int d = 0; d < 3; ++d)
    if (std::abs(lattice.step[d].unit().dot(lattice.step[(d + 1) % 3].unit())) > kRightAngle)
      throw InputError(
          "the axes of the voxels are not at right angles, which distances between labels need; put both "
          "maps on the voxels of an image first (`slicemorph convert --like`)");
}

template <typename Value>
std::vector<LabelComparison> compared(const ImageLattice& lattice, const Value& value) {
  const double voxel = std::abs(lattice.step[0].dot(lattice.step[1].cross(lattice.step[2])));
  std::vector<LabelComparison> result;
  for (const auto& [label, tally] : tallyBoth(lattice, value)) {
    LabelComparison c;
    c.label = label, c.shared = tally.shared;
    for (int m = 0; m < 2; ++m) {
      c.voxels[m] = tally.voxels[m], c.volume[m] = voxel * double(tally.voxels[m]);
      c.centroid[m] = tally.voxels[m] ? lattice.toWorld(tally.sum[m] / double(tally.voxels[m])) : Vec3d(0.0);
    }
    c.dice = 2 * double(tally.shared) / double(tally.voxels[0] + tally.voxels[1]);
    if (tally.voxels[0] && tally.voxels[1]) c.distance = distanceOfLabel(lattice, value, label, tally.box);
    result.push_back(c);
  }
  return result;
}

std::vector<std::int32_t> wholeNumbers(const ImageValues& values) {
  return std::visit(
      [](const auto& from) {
        std::vector<std::int32_t> to(from.size());
        tbb::parallel_for(size_t(0), from.size(),
                          [&](size_t i) { to[i] = std::int32_t(std::llround(double(from[i]))); });
        return to;
      },
      values);
}

template <typename T>
std::vector<LabelComparison> comparedValues(const ImageLattice& lattice, const std::vector<T>& a,
                                            const std::vector<T>& b) {
  return compared(lattice, [&](int map, size_t i) { return std::int64_t(map == 0 ? a[i] : b[i]); });
}

}  // namespace

std::vector<LabelComparison> compareLabels(const Image& a, const Image& b) {
  refuseLeaning(a.lattice);
  if (const auto* first = std::get_if<std::vector<std::uint8_t>>(&a.values))
    if (const auto* second = std::get_if<std::vector<std::uint8_t>>(&b.values))
      return comparedValues(a.lattice, *first, *second);
  if (const auto* first = std::get_if<std::vector<std::int16_t>>(&a.values))
    if (const auto* second = std::get_if<std::vector<std::int16_t>>(&b.values))
      return comparedValues(a.lattice, *first, *second);
  return comparedValues(a.lattice, wholeNumbers(a.values), wholeNumbers(b.values));
}

}  // namespace slicemorph
