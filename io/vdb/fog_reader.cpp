#include "io/vdb/fog_reader.h"

#include "engine/volume/level_set.h"
#include "io/vdb/grid_choice.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/placing.h"
#include "slicemorph/io/vdb_reader.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Grids that are drawn with a density; the first that is found is taken.
constexpr const char* kHeatNames[] = {"flame", "flames", "fire", "heat", "temperature"};
constexpr const char* kColourNames[] = {"color", "Cd"};

/// The grid as a density; null where it is not fog. Throws GeometryError for values that are not finite.
FloatGrid::ConstPtr readDensity(const VdbFile& file, size_t index, const std::string& path) {
  const openvdb::GridBase::Ptr header = file.readHeader(index);
  if (!header || header->getGridClass() == openvdb::GRID_LEVEL_SET) return nullptr;
  const FloatGrid::ConstPtr grid = asFloatGrid(file.read(index));
  if (grid->activeVoxelCount() == 0) {
    const bool named = grid->getName() == "density";
    return named || grid->getGridClass() == openvdb::GRID_FOG_VOLUME ? grid : nullptr;
  }
  const LevelSetReading reading = readingOf(*grid);
  if (!reading.fog) return nullptr;
  if (!std::isfinite(reading.minimum) || !std::isfinite(reading.maximum))
    throw GeometryError(path, "grid '" + file.entries()[index].name + "' holds values that are not finite");
  return grid;
}

/// A density with the heat and colour grids that are drawn with it. `find(name)`: the grid of that
/// name, or null.
template <typename Find>
Fog withDrawn(const FloatGrid::ConstPtr& density, const Find& find) {
  Fog fog;
  fog.density = density;
  for (const char* name : kHeatNames)
    if (const openvdb::GridBase::Ptr grid = fog.heat ? nullptr : find(name); grid && isScalar(*grid))
      fog.heat = asFloatGrid(grid);
  for (const char* name : kColourNames)
    if (const openvdb::GridBase::Ptr grid = fog.colour ? nullptr : find(name);
        grid && grid->isType<openvdb::Vec3SGrid>())
      fog.colour = openvdb::gridPtrCast<openvdb::Vec3SGrid>(grid);
  return fog;
}

}  // namespace

std::optional<Fog> readFog(const InputSpec& input) {
  if (!input.isGrids()) return std::nullopt;
  return readFog(VdbFile(input.path), input);
}

std::optional<Fog> readFog(const VdbFile& file, const InputSpec& input) {
  const size_t index = input.selection.empty() ? gridsToTry(file, input.path).front() : findGrid(file, input);
  const FloatGrid::ConstPtr stored = readDensity(file, index, input.path);
  if (!stored) return std::nullopt;
  const Placing placing = placingOf(input.placing, 'y');
  const openvdb::GridBase::Ptr density = placed(openvdb::ConstPtrCast<FloatGrid>(stored), placing);
  return withDrawn(openvdb::GridBase::grid<FloatGrid>(density),
                   [&](const std::string& wanted) -> openvdb::GridBase::Ptr {
                     const auto& entries = file.entries();
                     for (size_t i = 0; i < entries.size(); ++i)
                       if (i != index && (entries[i].name == wanted || entries[i].name == wanted + "[0]"))
                         return placed(file.read(i), placing);
                     return nullptr;
                   });
}

Fog fogOf(const openvdb::GridBase::ConstPtr& density, const openvdb::GridCPtrVec& grids) {
  return withDrawn(asFloatGrid(openvdb::ConstPtrCast<openvdb::GridBase>(density)),
                   [&](const std::string& wanted) -> openvdb::GridBase::Ptr {
                     for (const openvdb::GridBase::ConstPtr& grid : grids)
                       if (grid != density && grid->getName() == wanted)
                         return openvdb::ConstPtrCast<openvdb::GridBase>(grid);
                     return nullptr;
                   });
}

bool isDrawn(const std::string& name) {
  const auto isName = [&](const char* known) { return name == known; };
  return std::any_of(std::begin(kHeatNames), std::end(kHeatNames), isName) ||
         std::any_of(std::begin(kColourNames), std::end(kColourNames), isName);
}

}  // namespace slicemorph
