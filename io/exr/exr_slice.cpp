#include "io/exr/exr_slice.h"

namespace slicemorph {

bool isDistance(const openvdb::GridBase& grid) {
  return grid.getGridClass() == openvdb::GRID_LEVEL_SET &&
         (grid.isType<FloatGrid>() || grid.isType<openvdb::DoubleGrid>());
}

std::vector<std::string> sliceChannels(const std::string& name, const openvdb::GridBase& grid) {
  if (isDistance(grid)) return {name + ".sdf"};
  const bool vectors = grid.isType<openvdb::Vec3SGrid>() || grid.isType<openvdb::Vec3DGrid>() ||
                       grid.isType<openvdb::Vec3IGrid>();
  if (vectors) return {name + ".X", name + ".Y", name + ".Z"};
  return {name + ".Y"};
}

}  // namespace slicemorph
