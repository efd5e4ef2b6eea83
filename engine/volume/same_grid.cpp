#include "engine/volume/same_grid.h"

#include "engine/volume/level_set.h"

#include <cmath>
#include <cstring>

namespace slicemorph {

bool isSame(const FloatGrid& a, const FloatGrid& b) {
  if (&a == &b) return true;
  if (a.transform() != b.transform() || a.background() != b.background()) return false;
  if (a.activeVoxelCount() != b.activeVoxelCount() || !a.tree().hasSameTopology(b.tree())) return false;
  auto leafB = b.tree().cbeginLeaf();
  for (auto leafA = a.tree().cbeginLeaf(); leafA; ++leafA, ++leafB)
    if (std::memcmp(leafA->buffer().data(), leafB->buffer().data(), sizeof(float) * leafA->SIZE) != 0)
      return false;
  return true;
}

size_t indexOfSame(std::vector<FloatGrid::ConstPtr>& grids, const FloatGrid::ConstPtr& grid) {
  for (size_t i = 0; i < grids.size(); ++i)
    if (isSame(*grids[i], *grid)) return i;
  grids.push_back(grid);
  return grids.size() - 1;
}

FloatGrid::Ptr resampledTo(const FloatGrid::ConstPtr& levelSet, double voxelSize) {
  const double own = levelSet->voxelSize()[0];
  FloatGrid::Ptr grid = std::abs(voxelSize - own) <= 1e-9 * own
                            ? levelSet->deepCopy()
                            : toLevelSet(levelSet, voxelSize).grid->deepCopy();
  grid->setName("surface");
  return grid;
}

}  // namespace slicemorph
