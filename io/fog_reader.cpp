#include "io/fog_reader.h"

#include "engine/errors.h"
#include "engine/volume/level_set.h"
#include "io/grid_choice.h"
#include "io/paths.h"
#include "io/vdb_reader.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Index of a grid in the file, the first of several of that name; none: the number of grids.
size_t findName(const VdbFile& file, const std::string& name) {
  const auto& entries = file.entries();
  const auto has = [&](const VdbEntry& entry) { return entry.name == name || entry.name == name + "[0]"; };
  return size_t(std::find_if(entries.begin(), entries.end(), has) - entries.begin());
}

/// The density, null where the grid is none.
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
    throw GeometryError(path + ": grid '" + file.entries()[index].name +
                        "' holds values that are not finite");
  return grid;
}

FloatGrid::ConstPtr readHeat(const VdbFile& file, size_t density) {
  for (const char* name : {"flame", "flames", "fire", "heat", "temperature"}) {
    const size_t index = findName(file, name);
    if (index == file.entries().size() || index == density) continue;
    const openvdb::GridBase::Ptr header = file.readHeader(index);
    if (header && isScalar(*header)) return asFloatGrid(file.read(index));
  }
  return nullptr;
}

openvdb::Vec3SGrid::ConstPtr readColour(const VdbFile& file) {
  for (const char* name : {"color", "Cd"}) {
    const size_t index = findName(file, name);
    if (index == file.entries().size()) continue;
    const openvdb::GridBase::Ptr header = file.readHeader(index);
    if (header && header->isType<openvdb::Vec3SGrid>())
      return openvdb::GridBase::grid<openvdb::Vec3SGrid>(file.read(index));
  }
  return nullptr;
}

}  // namespace

std::optional<Fog> readFog(const std::string& input) {
  const InputName name = splitInput(input);
  if (extensionOf(name.path) != ".vdb") return std::nullopt;
  const VdbFile file(name.path);
  const size_t index = name.grid.empty() ? gridsToTry(file, name.path).front() : findGrid(file, name);
  Fog fog;
  fog.density = readDensity(file, index, name.path);
  if (!fog.density) return std::nullopt;
  fog.heat = readHeat(file, index);
  fog.colour = readColour(file);
  return fog;
}

}  // namespace slicemorph
