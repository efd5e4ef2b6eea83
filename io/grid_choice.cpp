#include "io/grid_choice.h"

#include "engine/errors.h"

namespace slicemorph {
namespace {

openvdb::GridBase::Ptr headerOrNull(const VdbFile& file, size_t index) {
  try {
    return file.readHeader(index);
  } catch (const IoError&) {
    return nullptr;
  }
}

std::string listOf(const VdbFile& file) {
  if (file.entries().empty()) return "the file holds no grids";
  std::string list = "the file holds";
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    const std::string kind =
        grid ? grid->valueType() + ", " + openvdb::GridBase::gridClassToMenuName(grid->getGridClass())
             : file.entries()[i].type;
    list += (i ? ", '" : " '") + file.entries()[i].name + "' (" + kind + ")";
  }
  return list;
}

}  // namespace

bool isScalar(const openvdb::GridBase& grid) {
  return grid.isType<FloatGrid>() || grid.isType<openvdb::DoubleGrid>();
}

size_t findGrid(const VdbFile& file, const InputName& name) {
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const bool first = file.entries()[i].name == name.grid + "[0]";
    if (file.entries()[i].name != name.grid && !first) continue;
    const openvdb::GridBase::Ptr grid = file.readHeader(i);
    if (grid && isScalar(*grid)) return i;
    throw InputError(name.path + ": grid '" + name.grid + "' holds " + (grid ? grid->valueType() : "unknown") +
                     " values, no scalar ones that have a surface; " + listOf(file));
  }
  throw InputError(name.path + ": there is no grid '" + name.grid + "'; " + listOf(file));
}

std::vector<size_t> gridsToTry(const VdbFile& file, const std::string& path) {
  std::vector<size_t> levelSets, others, fogs;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    if (!grid || !isScalar(*grid)) continue;
    const openvdb::GridClass gridClass = grid->getGridClass();
    (gridClass == openvdb::GRID_LEVEL_SET    ? levelSets
     : gridClass == openvdb::GRID_FOG_VOLUME ? fogs
                                             : others)
        .push_back(i);
  }
  levelSets.insert(levelSets.end(), others.begin(), others.end());
  levelSets.insert(levelSets.end(), fogs.begin(), fogs.end());
  if (levelSets.empty()) throw InputError(path + ": no grid of scalar values to take a surface from; " + listOf(file));
  return levelSets;
}

FloatGrid::ConstPtr asFloatGrid(const openvdb::GridBase::Ptr& grid) {
  if (const auto doubles = openvdb::GridBase::grid<openvdb::DoubleGrid>(grid)) {
    return FloatGrid::ConstPtr(new FloatGrid(*doubles));
  }
  return openvdb::GridBase::grid<FloatGrid>(grid);
}

}  // namespace slicemorph
