#include "engine/rebuild/redistance.h"

#include <openvdb/tools/SignedFloodFill.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <memory>

namespace slicemorph {

namespace {

using Leaf = openvdb::FloatTree::LeafNodeType;

/// One leaf's values with a margin of kBorder voxels from its neighbours: the band is 3 voxels wide and
/// interpolation reads one more.
class Block {
 public:
  static constexpr int kBorder = 4, kSide = kLeaf + 2 * kBorder;

  void gather(const SparseValues& values, size_t leaf) {
    const openvdb::Coord origin = values.origins()[leaf];
    for (int a = -1; a <= 1; ++a)
      for (int b = -1; b <= 1; ++b)
        for (int c = -1; c <= 1; ++c) {
          const float* from = values.find(origin.offsetBy(a * kLeaf, b * kLeaf, c * kLeaf));
          copy(from, a, b, c);
        }
  }

  const float* from(int x, int y, int z) const { return &v_[index(x, y, z)]; }

 private:
  static size_t index(int x, int y, int z) {
    return size_t(((x + kBorder) * kSide + (y + kBorder)) * kSide + (z + kBorder));
  }
  static void range(int side, int& first, int& last) {
    first = side < 0 ? -kBorder : side > 0 ? kLeaf : 0;
    last = side < 0 ? 0 : side > 0 ? kLeaf + kBorder : kLeaf;
  }
  void copy(const float* from, int a, int b, int c) {
    int x0, x1, y0, y1, z0, z1;
    range(a, x0, x1), range(b, y0, y1), range(c, z0, z1);
    for (int x = x0; x < x1; ++x)
      for (int y = y0; y < y1; ++y) {
        float* row = &v_[index(x, y, z0)];
        if (from)
          std::copy_n(from + leafOffset(x - a * kLeaf, y - b * kLeaf, z0 - c * kLeaf), z1 - z0, row);
        else
          std::fill_n(row, z1 - z0, SparseValues::kUnknown);
      }
  }
  float v_[kSide * kSide * kSide];
};

bool known(float v) { return v != SparseValues::kUnknown; }

/// Derivative per voxel along one axis: central if both neighbours are known, else one-sided.
float slope(float before, float here, float after) {
  if (known(before) && known(after)) return 0.5f * (after - before);
  if (known(after)) return after - here;
  if (known(before)) return here - before;
  return 0;
}

/// Trilinear value at a position in the block (voxels from the leaf's origin); kUnknown if a
/// corner is unknown.
float interpolate(const Block& block, const openvdb::Vec3s& p) {
  int base[3];
  float w[3];
  for (int a = 0; a < 3; ++a) {
    base[a] = int(p[a]) - (p[a] < float(int(p[a])));  // floor, without a call into the library
    if (base[a] < -Block::kBorder || base[a] + 1 >= kLeaf + Block::kBorder) return SparseValues::kUnknown;
    w[a] = p[a] - float(base[a]);
  }
  const float* v = block.from(base[0], base[1], base[2]);
  constexpr int dx = Block::kSide * Block::kSide, dy = Block::kSide;
  const float most = std::max({v[0], v[1], v[dy], v[dy + 1], v[dx], v[dx + 1], v[dx + dy], v[dx + dy + 1]});
  if (!known(most)) return most;
  const float p00 = v[0] + w[2] * (v[1] - v[0]), p01 = v[dy] + w[2] * (v[dy + 1] - v[dy]);
  const float p10 = v[dx] + w[2] * (v[dx + 1] - v[dx]),
              p11 = v[dx + dy] + w[2] * (v[dx + dy + 1] - v[dx + dy]);
  const float p0 = p00 + w[1] * (p01 - p00), p1 = p10 + w[1] * (p11 - p10);
  return p0 + w[0] * (p1 - p0);
}

/// Signed distance of voxel (x, y, z) in voxels, with the sign of its value; beyond the band at least the
/// half width.
float distanceAt(const Block& block, int x, int y, int z) {
  constexpr float kFar = float(kHalfWidth) * 1.01f;
  const float* v = block.from(x, y, z);
  constexpr int dx = Block::kSide * Block::kSide, dy = Block::kSide;
  const float here = v[0];
  const float around[6] = {v[-dx], v[dx], v[-dy], v[dy], v[-1], v[1]};
  openvdb::Vec3s g(slope(around[0], here, around[1]), slope(around[2], here, around[3]),
                   slope(around[4], here, around[5]));
  const float steepness2 = g.lengthSqr();
  float d = kFar;
  if (here * here < kFar * kFar * steepness2) {
    const float steepness = std::sqrt(steepness2);
    d = here / steepness;
    const float rest = interpolate(block, openvdb::Vec3s(float(x), float(y), float(z)) - g * (d / steepness));
    if (known(rest)) {
      const float corrected = d + rest / steepness;
      if ((corrected < 0) == (here < 0)) d = corrected;
    }
    d = std::min(std::abs(d), kFar);
  }
  // Next to a sign change the surface is less than a voxel away, whatever the gradient says.
  for (float neighbour : around)
    if (known(neighbour) && (neighbour < 0) != (here < 0))
      d = std::min(d, std::abs(here / (here - neighbour)));
  return std::copysign(d, here);
}

/// Computes one leaf's distances; returns null if no voxel lies in the band.
std::unique_ptr<Leaf> distanceLeaf(const SparseValues& values, size_t i, Block& block) {
  const float* from = values.leaf(i);
  const float h = values.voxelSize(), background = float(kHalfWidth) * h;
  float least = SparseValues::kUnknown;
  for (size_t n = 0; n < size_t(kLeafSize); ++n) least = std::min(least, std::abs(from[n]));
  if (least > 4 * background) return nullptr;
  block.gather(values, i);
  auto leaf = std::make_unique<Leaf>(values.origins()[i], background, false);
  bool any = false;
  for (int x = 0; x < kLeaf; ++x)
    for (int y = 0; y < kLeaf; ++y)
      for (int z = 0; z < kLeaf; ++z) {
        const size_t n = leafOffset(x, y, z);
        if (!known(from[n]) || std::abs(from[n]) > 4 * background) {
          if (known(from[n]) && from[n] < 0) leaf->setValueOnly(openvdb::Index(n), -background);
          continue;
        }
        const float d = h * distanceAt(block, x, y, z);
        if (std::abs(d) < background) {
          leaf->setValueOn(openvdb::Index(n), d);
          any = true;
        } else {
          leaf->setValueOnly(openvdb::Index(n), std::copysign(background, d));
        }
      }
  return any ? std::move(leaf) : nullptr;
}

}  // namespace

SparseValues::SparseValues(std::vector<openvdb::Coord> origins, float voxelSize)
    : origins_(std::move(origins)), voxelSize_(voxelSize), values_(origins_.size() * kLeafSize, kUnknown) {
  index_.reserve(origins_.size());
  for (size_t i = 0; i < origins_.size(); ++i) index_.emplace(origins_[i], i);
}

const float* SparseValues::find(const openvdb::Coord& origin) const {
  const auto it = index_.find(origin);
  return it == index_.end() ? nullptr : leaf(it->second);
}

FloatGrid::Ptr redistance(const SparseValues& values, const openvdb::math::Transform& transform) {
  const size_t count = values.origins().size();
  std::vector<std::unique_ptr<Leaf>> leaves(count);
  tbb::parallel_for(tbb::blocked_range<size_t>(0, count), [&](const tbb::blocked_range<size_t>& range) {
    Block block;
    for (size_t i = range.begin(); i < range.end(); ++i) leaves[i] = distanceLeaf(values, i, block);
  });
  FloatGrid::Ptr grid = FloatGrid::create(float(kHalfWidth) * values.voxelSize());
  for (auto& leaf : leaves)
    if (leaf) grid->tree().addLeaf(leaf.release());
  openvdb::tools::signedFloodFill(grid->tree());
  grid->setTransform(transform.copy());
  grid->setGridClass(openvdb::GRID_LEVEL_SET);
  grid->setName("surface");
  return grid;
}

}  // namespace slicemorph
