#include "engine/blend/box_nodes.h"

#include <algorithm>
#include <cstdint>

namespace slicemorph {

namespace {

/// Cells along the side of a block, whose box is looked at before those of its cells.
constexpr int kBlockCells = 4;

/// The number of marked nodes in any box of a map, by a table of sums [Cro84].
class NodeCounts {
 public:
  NodeCounts(const NodeMap& map, const std::vector<char>& marked)
      : origin_(map.origin),
        size_(map.size),
        sums_(size_t(map.size[0] + 1) * (map.size[1] + 1) * (map.size[2] + 1), 0) {
    for (int z = 0; z < size_[2]; ++z)
      for (int y = 0; y < size_[1]; ++y) {
        std::int32_t row = 0;
        for (int x = 0; x < size_[0]; ++x) {
          row += marked[(size_t(z) * size_[1] + y) * size_[0] + x] != 0;
          sums_[at(x + 1, y + 1, z + 1)] =
              row + sums_[at(x + 1, y, z + 1)] + sums_[at(x + 1, y + 1, z)] - sums_[at(x + 1, y, z)];
        }
      }
  }

  /// Whether a marked node is in a box, in nodes, or less than one outside of it.
  bool any(const openvdb::BBoxd& box) const {
    openvdb::Coord low = openvdb::Coord::floor(box.min()) - origin_,
                   high = openvdb::Coord::ceil(box.max()) - origin_ + openvdb::Coord(1);
    low.maxComponent({0, 0, 0});
    high.minComponent(size_);
    if (low[0] >= high[0] || low[1] >= high[1] || low[2] >= high[2]) return false;
    const auto upTo = [&](int z) {
      return sums_[at(high[0], high[1], z)] - sums_[at(low[0], high[1], z)] - sums_[at(high[0], low[1], z)] +
             sums_[at(low[0], low[1], z)];
    };
    return upTo(high[2]) != upTo(low[2]);
  }

 private:
  size_t at(int x, int y, int z) const { return (size_t(z) * (size_[1] + 1) + y) * (size_[0] + 1) + x; }
  openvdb::Coord origin_, size_;
  std::vector<std::int32_t> sums_;
};

}  // namespace

NodeMap emptyNodes(const openvdb::CoordBBox& box, int step) {
  NodeMap map;
  map.step = step;
  map.origin = openvdb::Coord::floor(box.min().asVec3d() / step) - openvdb::Coord(1);
  map.size = openvdb::Coord::ceil(box.max().asVec3d() / step) + openvdb::Coord(2) - map.origin;
  return map;
}

NodeMap boxNodes(const openvdb::CoordBBox& box, const Lattice& lattice, const LatticePose& pose,
                 const openvdb::math::Transform& transform, int step, const NodeFields& fields) {
  NodeMap map = emptyNodes(box, step);
  PosedLattice(lattice, pose, transform, step, std::vector<char>(lattice.count(), 1)).place(map);
  evaluateAtPlaces(lattice, fields.onLattice, map);
  forUnknownNodes(map, pose.chart, transform, [&](const Vec3d& q, size_t n) {
    for (size_t f = 0; f < map.objects; ++f) map.at[n * map.objects + f] = fields.beyond(q, f);
    map.known[n] = 1;
  });
  return map;
}

PlaceFinder::PlaceFinder(const Lattice& lattice, const LatticePose& pose,
                         const openvdb::math::Transform& transform, int step)
    : lattice_(lattice), pose_(pose), transform_(transform), step_(step) {
  for (int axis = 0; axis < 3; ++axis)
    blockCount_[axis] = std::max((lattice.size[axis] - 1 + kBlockCells - 1) / kBlockCells, 0);
  blocks_.resize(size_t(blockCount_[0]) * blockCount_[1] * blockCount_[2]);
  tbb::parallel_for(0, int(blocks_.size()), [&](int i) {
    const openvdb::Coord block(i % blockCount_[0], i / blockCount_[0] % blockCount_[1],
                               i / (blockCount_[0] * blockCount_[1]));
    blocks_[size_t(i)] =
        boxOfCells({block[0] * kBlockCells, block[1] * kBlockCells, block[2] * kBlockCells}, kBlockCells);
  });
}

/// A box, in nodes of a map, of the nodes of `cells` along each side from the one with this first node on.
openvdb::BBoxd PlaceFinder::boxOfCells(const openvdb::Coord& first, int cells) const {
  const bool linear = transform_.isLinear();
  openvdb::Coord last = first + openvdb::Coord(cells);
  last.minComponent(lattice_.size - openvdb::Coord(1));
  Vec3d low(1e30), high(-1e30);
  for (int z = first[2]; z <= last[2]; ++z)
    for (int y = first[1]; y <= last[1]; ++y)
      for (int x = first[0]; x <= last[0]; ++x) {
        const size_t i = lattice_.index(x, y, z);
        const Vec3d p = linear ? pose_.world[i] : inNodes(pose_, i, transform_, step_);
        low = openvdb::math::minComponent(low, p), high = openvdb::math::maxComponent(high, p);
      }
  if (!linear) return {low, high};
  const openvdb::BBoxd index = transform_.worldToIndex(openvdb::BBoxd(low, high));
  return {index.min() / step_, index.max() / step_};
}

/// The cells whose box holds a wanted node.
std::vector<char> PlaceFinder::cellsWith(const NodeMap& map, const std::vector<char>& wanted) const {
  const NodeCounts counts(map, wanted);
  std::vector<char> cells(lattice_.count(), 0);
  tbb::parallel_for(0, int(blocks_.size()), [&](int i) {
    if (!counts.any(blocks_[size_t(i)])) return;
    const openvdb::Coord first(i % blockCount_[0] * kBlockCells,
                               i / blockCount_[0] % blockCount_[1] * kBlockCells,
                               i / (blockCount_[0] * blockCount_[1]) * kBlockCells);
    openvdb::Coord end = first + openvdb::Coord(kBlockCells);
    end.minComponent(lattice_.size - openvdb::Coord(1));
    for (int z = first[2]; z < end[2]; ++z)
      for (int y = first[1]; y < end[1]; ++y)
        for (int x = first[0]; x < end[0]; ++x)
          cells[lattice_.index(x, y, z)] = counts.any(boxOfCells({x, y, z}, 1));
  });
  return cells;
}

NodeMap PlaceFinder::find(NodeMap map, const std::vector<char>& wanted) const {
  PosedLattice(lattice_, pose_, transform_, step_, cellsWith(map, wanted)).place(map);
  return map;
}

openvdb::BBoxd boxOnPose(const LatticeOnObjects& on, size_t object, const openvdb::BBoxd& world,
                         const LatticePose& pose, const openvdb::math::Transform& transform) {
  openvdb::BBoxd box;
  for (int corner = 0; corner < 8; ++corner) {
    const Vec3d at(world.min()[0] + (corner & 1) * world.extents()[0],
                   world.min()[1] + (corner >> 1 & 1) * world.extents()[1],
                   world.min()[2] + (corner >> 2) * world.extents()[2]);
    box.expand(transform.worldToIndex(pose.chart.toWorld(on.charts[object].toChart(at))));
  }
  // Include nodes up to a cell outside: the space between nodes reaches as far.
  const Vec3d cell(on.lattice.spacing * on.charts[object].meanScale());
  const openvdb::BBoxd wide(world.min() - cell, world.max() + cell);
  for (size_t i = 0; i < on.lattice.count(); ++i)
    if (wide.isInside(on.anchor[object] + Vec3d(on.position[object][i])))
      box.expand(transform.worldToIndex(pose.world[i]));
  return box;
}

}  // namespace slicemorph
