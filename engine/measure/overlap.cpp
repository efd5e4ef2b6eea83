#include "engine/measure/matching_grid.h"
#include "engine/measure/measure.h"

#include <openvdb/tools/Interpolation.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
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

/// Overlap of two level sets on voxels of one transform.
Overlap overlapOnSame(const FloatGrid& a, const FloatGrid& b) {
  const double h = a.voxelSize()[0], voxel = h * h * h;
  Sums sums = sumBands(a.tree(), b.tree(), h);
  const TileCount fromA = countInsideTiles(a.tree(), b.tree());
  const TileCount fromB = countInsideTiles(b.tree(), a.tree());
  sums.a += double(Leaf::SIZE) * (fromA.both + fromA.only);
  sums.b += double(Leaf::SIZE) * (fromB.both + fromB.only);
  sums.both += double(Leaf::SIZE) * fromA.both;
  sums.difference += double(Leaf::SIZE) * (fromA.only + fromB.only);
  return {sums.a + sums.b > 0 ? 2 * sums.both / (sums.a + sums.b) : 1, sums.both * voxel,
          sums.difference * voxel};
}

/// Most leaves that the coarser level set may get when it is resampled for a comparison: 64 MiB of values, or
/// this many times what both have.
constexpr double kFewLeaves = 32768, kLeavesGrow = 4;

/// Whether resampling to the finer voxels costs little. A leaf that is resampled touches the leaves around it, too.
bool isCheaplyResampled(const FloatGrid& fine, const FloatGrid& coarse) {
  const double ratio = coarse.voxelSize()[0] / fine.voxelSize()[0];
  const double own = double(coarse.tree().leafCount());
  const double leaves = own * std::pow(ratio + 3.0 / Leaf::DIM, 3);
  return leaves <= std::max(kFewLeaves, kLeavesGrow * (own + double(fine.tree().leafCount())));
}

/// A box in which the finer of two level sets has a leaf, or is inside; then `leaf` is null.
struct FinePart {
  openvdb::CoordBBox box;
  const Leaf* leaf = nullptr;
};

/// The finer level set's leaves and inside tiles within the coarser one's box.
std::vector<FinePart> fineParts(const FloatGrid& fine, const FloatGrid& coarse) {
  openvdb::CoordBBox reach;
  if (!coarse.tree().evalLeafBoundingBox(reach)) return {};
  const openvdb::BBoxd box = fine.transform().worldToIndex(coarse.transform().indexToWorld(reach));
  const openvdb::CoordBBox within(Coord::floor(box.min()), Coord::ceil(box.max()));
  std::vector<FinePart> parts;
  for (auto leaf = fine.tree().cbeginLeaf(); leaf; ++leaf)
    if (within.hasOverlap(leaf->getNodeBoundingBox())) parts.push_back({leaf->getNodeBoundingBox(), &*leaf});
  auto tile = fine.tree().cbeginValueAll();
  tile.setMaxDepth(decltype(tile)::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox part = tile.getBoundingBox();
    part.intersect(within);
    if (tile.getValue() < 0 && !part.empty()) parts.push_back({part});
  }
  return parts;
}

/// Sums what is inside two level sets over the voxels of the finer one, without a copy of either.
class SharedVolume {
 public:
  SharedVolume(const FloatGrid& fine, const FloatGrid& coarse)
      : fine_(fine), coarse_(coarse), voxel_(fine.voxelSize()[0]), accessor_(coarse.getConstAccessor()) {}

  /// In voxels of the finer one.
  double in(const FinePart& part) {
    const Vec3d half = part.box.dim().asVec3d() / 2;
    const double middle = coarseAt(part.box.getCenter());
    // The coarser one's distances are exact to less than one of its own voxels.
    if (std::abs(middle) > half.length() * voxel_ + coarse_.voxelSize()[0] / 2)
      return middle > 0 ? 0 : part.leaf ? ownOf(*part.leaf) : double(part.box.volume());
    return part.leaf || part.box.dim()[int(part.box.maxExtent())] <= int(Leaf::DIM) ? sampled(part)
                                                                                    : halves(part);
  }

 private:
  double coarseAt(const Vec3d& index) {
    const Vec3d at = coarse_.transform().worldToIndex(fine_.transform().indexToWorld(index));
    return double(openvdb::tools::BoxSampler::sample(accessor_, at));
  }
  double ownOf(const Leaf& leaf) const {
    double sum = 0;
    for (openvdb::Index i = 0; i < Leaf::SIZE; ++i) sum += insideShare(leaf.getValue(i), voxel_);
    return sum;
  }
  double sampled(const FinePart& part) {
    double sum = 0;
    for (auto at = part.box.begin(); at; ++at) {
      const double own = part.leaf ? insideShare(part.leaf->getValue(*at), voxel_) : 1;
      if (own > 0) sum += std::min(own, insideShare(float(coarseAt((*at).asVec3d())), voxel_));
    }
    return sum;
  }
  double halves(const FinePart& part) {
    FinePart low = part, high = part;
    const int axis = int(part.box.maxExtent()), middle = (part.box.min()[axis] + part.box.max()[axis]) >> 1;
    low.box.max()[axis] = middle, high.box.min()[axis] = middle + 1;
    return in(low) + in(high);
  }

  const FloatGrid &fine_, &coarse_;
  double voxel_;
  FloatGrid::ConstAccessor accessor_;
};

/// Overlap of level sets with voxels of different sizes, each measured on its own.
Overlap overlapOnOwn(const FloatGrid& fine, const FloatGrid& coarse) {
  const std::vector<FinePart> parts = fineParts(fine, coarse);
  std::vector<double> sums(parts.size());
  tbb::parallel_for(tbb::blocked_range<size_t>(0, parts.size(), 64), [&](const auto& range) {
    SharedVolume shared(fine, coarse);
    for (size_t i = range.begin(); i != range.end(); ++i) sums[i] = shared.in(parts[i]);
  });
  double both = 0;
  for (double sum : sums) both += sum;
  both *= std::pow(fine.voxelSize()[0], 3);
  const double all = overlapOnSame(fine, fine).intersection + overlapOnSame(coarse, coarse).intersection;
  return {all > 0 ? std::min(2 * both / all, 1.0) : 1, both, std::max(all - 2 * both, 0.0)};
}

}  // namespace

Overlap overlap(const FloatGrid& a, const FloatGrid& b) {
  if (a.transform() == b.transform()) return overlapOnSame(a, b);
  const bool finerA = a.voxelSize()[0] <= b.voxelSize()[0];
  const FloatGrid &fine = finerA ? a : b, &coarse = finerA ? b : a;
  if (!isCheaplyResampled(fine, coarse)) return overlapOnOwn(fine, coarse);
  const FloatGrid::Ptr resampled = sampleOnto(coarse, fine.transform());
  return finerA ? overlapOnSame(a, *resampled) : overlapOnSame(*resampled, b);
}

}  // namespace slicemorph
