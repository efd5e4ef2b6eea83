#include "engine/sections/object_boxes.h"

#include <type_traits>

namespace slicemorph {
namespace {

using openvdb::Coord;
using openvdb::CoordBBox;

/// Adds the runs of consecutive voxels along z that `holds` accepts in one leaf.
template <typename Leaf, typename Holds>
void addRuns(const Leaf& leaf, const Holds& holds, std::vector<CoordBBox>& boxes) {
  constexpr int kSide = int(Leaf::DIM);
  for (int row = 0; row < kSide * kSide; ++row) {
    const Coord start = leaf.origin().offsetBy(row / kSide, row % kSide, 0);
    int from = -1;
    for (int z = 0; z <= kSide; ++z) {
      const bool in = z < kSide && holds(leaf, openvdb::Index(row * kSide + z));
      if (in && from < 0) from = z;
      if (in || from < 0) continue;
      boxes.emplace_back(start.offsetBy(0, 0, from), start.offsetBy(0, 0, z - 1));
      from = -1;
    }
  }
}

template <typename Grid>
void addInside(const Grid& grid, std::vector<CoordBBox>& boxes) {
  const auto inside = [](const auto& leaf, openvdb::Index n) { return leaf.getValue(n) < 0; };
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) addRuns(*leaf, inside, boxes);
  auto tile = grid.tree().cbeginValueAll();
  for (tile.setMaxDepth(Grid::TreeType::ValueAllCIter::LEAF_DEPTH - 1); tile; ++tile)
    if (*tile < 0) boxes.push_back(tile.getBoundingBox());
}

template <typename Grid>
void addActive(const Grid& grid, std::vector<CoordBBox>& boxes) {
  const auto active = [](const auto& leaf, openvdb::Index n) { return leaf.isValueOn(n); };
  for (auto leaf = grid.tree().cbeginLeaf(); leaf; ++leaf) {
    if (leaf->isDense())
      boxes.push_back(leaf->getNodeBoundingBox());
    else
      addRuns(*leaf, active, boxes);
  }
  auto tile = grid.tree().cbeginValueOn();
  for (tile.setMaxDepth(Grid::TreeType::ValueOnCIter::LEAF_DEPTH - 1); tile; ++tile)
    boxes.push_back(tile.getBoundingBox());
}

}  // namespace

bool isSliceable(const openvdb::GridBase& grid) {
  return grid.apply<SliceableTypes>([](const auto&) {});
}

std::vector<CoordBBox> objectBoxes(const openvdb::GridBase& grid) {
  std::vector<CoordBBox> boxes;
  grid.apply<SliceableTypes>([&](const auto& typed) {
    using Grid = std::decay_t<decltype(typed)>;
    if constexpr (std::is_floating_point_v<typename Grid::ValueType>) {
      if (typed.getGridClass() == openvdb::GRID_LEVEL_SET) return addInside(typed, boxes);
    }
    addActive(typed, boxes);
  });
  return boxes;
}

}  // namespace slicemorph
