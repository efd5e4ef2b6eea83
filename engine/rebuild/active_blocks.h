#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// The blocks of 8 x 8 x 8 voxels of a grid that contain at least one active voxel. Built once, then queried
/// by box.
class ActiveBlocks {
 public:
  template <typename TreeType>
  explicit ActiveBlocks(const TreeType& tree);
  /// Whether the box (index space) overlaps any block with active voxels.
  bool meets(const openvdb::BBoxd& box) const;

 private:
  static constexpr int kSide = 8;
  static openvdb::Coord blockOf(const Vec3d& index) { return openvdb::Coord::floor(index / kSide); }
  void reserve(const openvdb::CoordBBox& voxels);
  void add(const openvdb::CoordBBox& voxels);
  size_t index(const openvdb::Coord& block) const {
    const openvdb::Coord c = block - low_;
    return (size_t(c[2]) * size_[1] + c[1]) * size_[0] + c[0];
  }

  openvdb::Coord low_{0, 0, 0}, size_{0, 0, 0};
  std::vector<char> active_;
};

inline void ActiveBlocks::reserve(const openvdb::CoordBBox& voxels) {
  if (voxels.empty()) return;
  low_ = blockOf(voxels.min().asVec3d());
  size_ = blockOf(voxels.max().asVec3d()) - low_ + openvdb::Coord(1);
  active_.assign(size_t(size_[0]) * size_[1] * size_[2], 0);
}

inline void ActiveBlocks::add(const openvdb::CoordBBox& voxels) {
  const openvdb::CoordBBox blocks(blockOf(voxels.min().asVec3d()), blockOf(voxels.max().asVec3d()));
  for (auto it = blocks.begin(); it; ++it) active_[index(*it)] = 1;
}

inline bool ActiveBlocks::meets(const openvdb::BBoxd& box) const {
  openvdb::Coord low = blockOf(box.min()), high = blockOf(box.max());
  low.maxComponent(low_);
  high.minComponent(low_ + size_ - openvdb::Coord(1));
  for (int z = low[2]; z <= high[2]; ++z)
    for (int y = low[1]; y <= high[1]; ++y)
      for (int x = low[0]; x <= high[0]; ++x)
        if (active_[index({x, y, z})]) return true;
  return false;
}

template <typename TreeType>
ActiveBlocks::ActiveBlocks(const TreeType& tree) {
  openvdb::CoordBBox box;
  tree.evalActiveVoxelBoundingBox(box);
  reserve(box);
  for (auto leaf = tree.cbeginLeaf(); leaf; ++leaf)
    if (!leaf->isEmpty()) add(leaf->getNodeBoundingBox());
  auto tile = tree.cbeginValueOn();
  tile.setMaxDepth(TreeType::ValueOnCIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) {
    openvdb::CoordBBox voxels;
    tile.getBoundingBox(voxels);
    add(voxels);
  }
}

}  // namespace slicemorph
