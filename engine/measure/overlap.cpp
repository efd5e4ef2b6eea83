#include "engine/measure/matching_grid.h"
#include "engine/measure/measure.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cstdint>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::FloatTree;
using Leaf = FloatTree::LeafNodeType;

/// Volumes in voxels.
struct Sums {
  double a = 0, b = 0, both = 0, difference = 0;

  void add(double fractionA, double fractionB) {
    a += fractionA, b += fractionB;
    both += std::min(fractionA, fractionB);
    difference += std::abs(fractionA - fractionB);
  }
};

/// Share of a voxel that is inside a plane at the given distance from its centre.
double insideShare(float distance, double voxelSize) {
  return std::clamp(0.5 - distance / voxelSize, 0.0, 1.0);
}

/// Blocks of 8^3 voxels in which at least one of the trees has a leaf.
std::vector<Coord> bandBlocks(const FloatTree& a, const FloatTree& b) {
  std::vector<Coord> blocks;
  for (auto leaf = a.cbeginLeaf(); leaf; ++leaf) blocks.push_back(leaf->origin());
  for (auto leaf = b.cbeginLeaf(); leaf; ++leaf)
    if (!a.probeConstLeaf(leaf->origin())) blocks.push_back(leaf->origin());
  return blocks;
}

/// One tree's values in a block: those of its leaf, or of the tile that covers it.
struct Block {
  Block(const FloatTree& tree, const Coord& origin)
      : leaf(tree.probeConstLeaf(origin)), tile(leaf ? 0 : tree.getValue(origin)) {}
  float value(openvdb::Index i) const { return leaf ? leaf->getValue(i) : tile; }
  const Leaf* leaf;
  float tile;
};

Sums sumBlock(const FloatTree& a, const FloatTree& b, const Coord& origin, double voxelSize) {
  const Block blockA(a, origin), blockB(b, origin);
  Sums sums;
  for (openvdb::Index i = 0; i < Leaf::SIZE; ++i)
    sums.add(insideShare(blockA.value(i), voxelSize), insideShare(blockB.value(i), voxelSize));
  return sums;
}

Sums sumBands(const FloatTree& a, const FloatTree& b, double voxelSize) {
  const std::vector<Coord> blocks = bandBlocks(a, b);
  std::vector<Sums> parts(blocks.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, blocks.size(), 64), [&](const auto& range) {
    for (size_t i = range.begin(); i != range.end(); ++i) parts[i] = sumBlock(a, b, blocks[i], voxelSize);
  });
  Sums total;
  for (const Sums& part : parts)
    total.a += part.a, total.b += part.b, total.both += part.both, total.difference += part.difference;
  return total;
}

/// Counts blocks that are in inside tiles of `tree` and where `other` has no leaf: `both` are inside `other`,
/// too, `only` are not.
struct TileCount {
  std::int64_t both = 0, only = 0;
};

TileCount countInsideTiles(const FloatTree& tree, const FloatTree& other) {
  TileCount count;
  openvdb::tree::ValueAccessor<const FloatTree> accessor(other);
  auto tile = tree.cbeginValueAll();
  tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    if (!(tile.getValue() < 0)) continue;
    const openvdb::CoordBBox box = tile.getBoundingBox();
    for (int x = box.min().x(); x <= box.max().x(); x += Leaf::DIM)
      for (int y = box.min().y(); y <= box.max().y(); y += Leaf::DIM)
        for (int z = box.min().z(); z <= box.max().z(); z += Leaf::DIM) {
          if (accessor.probeConstLeaf(Coord(x, y, z))) continue;
          ++(accessor.getValue(Coord(x, y, z)) < 0 ? count.both : count.only);
        }
  }
  return count;
}

}  // namespace

Overlap overlap(const FloatGrid& a, const FloatGrid& b) {
  FloatGrid::Ptr resampled;
  const FloatGrid *gridA = &a, *gridB = &b;
  if (a.transform() != b.transform()) {
    const bool finerA = a.voxelSize()[0] <= b.voxelSize()[0];
    resampled = finerA ? sampleOnto(b, a.transform()) : sampleOnto(a, b.transform());
    (finerA ? gridB : gridA) = resampled.get();
  }
  const double h = gridA->voxelSize()[0], voxel = h * h * h;
  Sums sums = sumBands(gridA->tree(), gridB->tree(), h);
  const TileCount fromA = countInsideTiles(gridA->tree(), gridB->tree());
  const TileCount fromB = countInsideTiles(gridB->tree(), gridA->tree());
  sums.a += double(Leaf::SIZE) * (fromA.both + fromA.only);
  sums.b += double(Leaf::SIZE) * (fromB.both + fromB.only);
  sums.both += double(Leaf::SIZE) * fromA.both;
  sums.difference += double(Leaf::SIZE) * (fromA.only + fromB.only);

  Overlap result;
  result.intersection = sums.both * voxel;
  result.symmetricDifference = sums.difference * voxel;
  result.dice = sums.a + sums.b > 0 ? 2 * sums.both / (sums.a + sums.b) : 1;
  return result;
}

}  // namespace slicemorph
