#include "io/vdb/grid_choice.h"

#include "engine/volume/surface_colors.h"
#include "slicemorph/errors.h"

namespace slicemorph {
namespace {

openvdb::GridBase::Ptr headerOrNull(const VdbFile& file, size_t index) {
  try {
    return file.readHeader(index);
  } catch (const IoError&) {
    return nullptr;
  }
}

/// Whether nearly all of the grid's box is active, by the statistics in its header. A narrow band fills a
/// small part of its box, the domain of a simulation all of it; 90 % is far from both.
bool isDense(const openvdb::GridBase& grid) {
  const auto count = grid.getMetadata<openvdb::Int64Metadata>(openvdb::GridBase::META_FILE_VOXEL_COUNT);
  const auto low = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MIN);
  const auto high = grid.getMetadata<openvdb::Vec3IMetadata>(openvdb::GridBase::META_FILE_BBOX_MAX);
  if (!count || !low || !high) return false;
  const openvdb::CoordBBox box{openvdb::Coord(low->value()), openvdb::Coord(high->value())};
  return double(count->value()) > 0.9 * double(box.volume());
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

size_t findGrid(const VdbFile& file, const InputSpec& input) {
  const std::string& name = input.selection;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const bool first = file.entries()[i].name == name + "[0]";
    if (file.entries()[i].name != name && !first) continue;
    const openvdb::GridBase::Ptr grid = file.readHeader(i);
    if (grid && isScalar(*grid)) return i;
    throw InputError(input.path, "grid '" + name + "' holds " + (grid ? grid->valueType() : "unknown") +
                                     " values, no scalar ones that have a surface; " + listOf(file));
  }
  throw InputError(input.path, "there is no grid '" + name + "'; " + listOf(file));
}

std::vector<size_t> gridsToTry(const VdbFile& file, const std::string& path) {
  std::vector<size_t> levelSets, density, dense, others, fogs;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    if (!grid || !isScalar(*grid)) continue;
    const openvdb::GridClass gridClass = grid->getGridClass();
    if (gridClass == openvdb::GRID_LEVEL_SET)
      (isDense(*grid) ? dense : levelSets).push_back(i);
    else if (grid->getName() == "density")
      density.push_back(i);
    else
      (gridClass == openvdb::GRID_FOG_VOLUME ? fogs : others).push_back(i);
  }
  for (const auto* more : {&density, &dense, &others, &fogs})
    levelSets.insert(levelSets.end(), more->begin(), more->end());
  if (levelSets.empty())
    throw InputError(path, "no grid of scalar values to take a surface from; " + listOf(file));
  return levelSets;
}

std::optional<size_t> findColors(const VdbFile& file) {
  const auto rank = [](const std::string& name) { return name == "Cd" ? 0 : name == "color" ? 1 : 2; };
  std::optional<size_t> best;
  int least = 3;
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const openvdb::GridBase::Ptr grid = headerOrNull(file, i);
    if (!grid || !isColorName(grid->getName()) || rank(grid->getName()) >= least) continue;
    if (!grid->isType<openvdb::Vec3SGrid>() && !grid->isType<openvdb::Vec3DGrid>()) continue;
    best = i, least = rank(grid->getName());
  }
  return best;
}

openvdb::Vec3SGrid::ConstPtr asColorGrid(const openvdb::GridBase::Ptr& grid) {
  if (const auto doubles = openvdb::GridBase::grid<openvdb::Vec3DGrid>(grid)) {
    return openvdb::Vec3SGrid::ConstPtr(new openvdb::Vec3SGrid(*doubles));
  }
  return openvdb::GridBase::grid<openvdb::Vec3SGrid>(grid);
}

FloatGrid::ConstPtr asFloatGrid(const openvdb::GridBase::Ptr& grid) {
  if (const auto doubles = openvdb::GridBase::grid<openvdb::DoubleGrid>(grid)) {
    return FloatGrid::ConstPtr(new FloatGrid(*doubles));
  }
  return openvdb::GridBase::grid<FloatGrid>(grid);
}

}  // namespace slicemorph
