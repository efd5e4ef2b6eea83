#include "engine/volume/faint_values.h"

#include <openvdb/tools/Prune.h>
#include <openvdb/tree/LeafManager.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace slicemorph {

namespace {

using FaintTypes = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid>;

/// Calls `action(v)` for an iterator at each active tile.
template <typename Tree, typename Action>
void forTiles(Tree& tree, const Action& action) {
  auto tile = tree.beginValueOn();
  tile.setMaxDepth(Tree::ValueOnIter::LEAF_DEPTH - 1);
  for (; tile; ++tile) action(tile);
}

}  // namespace

double faintestValue(const openvdb::GridBase& grid) {
  double least = std::numeric_limits<double>::infinity();
  grid.apply<FaintTypes>([&](const auto& values) {
    for (auto v = values.cbeginValueOn(); v; ++v)
      if (*v != 0) least = std::min(least, std::abs(double(*v)));
  });
  return least;
}

void dropFainter(openvdb::GridBase& grid, double least) {
  grid.apply<FaintTypes>([&](auto& values) {
    using Tree = typename std::decay_t<decltype(values)>::TreeType;
    const auto background = values.background();
    const auto faint = [&](double value) { return value == 0 || std::abs(value) < least; };
    openvdb::tree::LeafManager<Tree> leaves(values.tree());
    leaves.foreach ([&](typename Tree::LeafNodeType& leaf, size_t) {
      for (auto v = leaf.beginValueOn(); v; ++v)
        if (faint(double(*v))) leaf.setValueOff(v.pos(), background);
    });
    forTiles(values.tree(), [&](auto& tile) {
      if (faint(double(*tile))) tile.setValue(background), tile.setActiveState(false);
    });
    openvdb::tools::pruneInactive(values.tree());
  });
}

}  // namespace slicemorph
