#include "io/input_grids.h"

#include "engine/sections/object_boxes.h"
#include "engine/volume/image_grid.h"
#include "io/output.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <algorithm>

namespace slicemorph {
namespace {

bool isWanted(const std::string& name, const std::vector<std::string>& wanted) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
}

/// All grids of a VDB that can be sliced and have voxels; of an input that names one that alone.
void addVdb(const InputName& name, const std::vector<std::string>& wanted, bool surface, InputGrids& result) {
  const VdbFile file(name.path);
  result.metadata = file.metadata();
  std::string there = surface ? "surface" : "";
  std::vector<std::string> missing = wanted;
  if (!name.grid.empty()) missing.push_back(name.grid);
  missing.erase(std::remove(missing.begin(), missing.end(), surface ? "surface" : ""), missing.end());
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const std::string& own = file.entries()[i].name;
    there += (there.empty() ? "" : ", ") + own;
    missing.erase(std::remove(missing.begin(), missing.end(), own), missing.end());
    if (!isWanted(own, wanted) || (!name.grid.empty() && own != name.grid)) continue;
    const openvdb::GridBase::ConstPtr header = file.readHeader(i);
    if (!header || !isSliceable(*header)) {
      result.notes.push_back("grid '" + own + "' is left out: values of the type " + file.entries()[i].type +
                             " cannot be sliced");
      continue;
    }
    const openvdb::GridBase::Ptr grid = file.readDelayed(i);
    if (objectBoxes(*grid).empty()) {
      result.notes.push_back("grid '" + own + "' is left out: it is empty");
      continue;
    }
    result.grids.push_back({own.empty() ? "value" : own, grid});
  }
  if (!missing.empty())
    throw InputError(name.path + ": there is no grid '" + missing[0] + "'; there are " + there);
}

void checkNames(const std::string& input, const std::vector<std::string>& wanted,
                const std::vector<std::string>& there) {
  for (const std::string& name : wanted)
    if (std::find(there.begin(), there.end(), name) == there.end()) {
      std::string list;
      for (const std::string& known : there) list += (list.empty() ? "" : ", ") + known;
      throw InputError(input + ": there is no grid '" + name + "'; there are " + list);
    }
}

}  // namespace

InputGrids readInputGrids(const std::string& input, const std::vector<std::string>& wanted,
                          const LoadOptions& options, bool needsShape) {
  initialiseVdb();
  const InputName name = splitInput(input);
  const bool image = isImageInput(input), vdb = !image && extensionOf(name.path) == ".vdb";
  const bool surface = (!image && !vdb) || options.isoGiven;
  InputGrids result;
  result.units = image ? "mm" : "world units";
  if (vdb) addVdb(name, wanted, surface, result);
  LoadedObject loaded;
  if (image || needsShape || (surface && isWanted("surface", wanted))) {
    loaded = loadObject(input, options);
    result.shape = loaded.object.levelSet;
    result.notes.insert(result.notes.end(), loaded.notes.begin(), loaded.notes.end());
  }
  if (image) {
    const std::string values = loaded.labels ? "labels" : "image";
    checkNames(input, wanted,
               surface ? std::vector<std::string>{values, "surface"} : std::vector<std::string>{values});
    if (isWanted(values, wanted))
      result.grids.push_back({values, gridOf(*loaded.image, values, loaded.labels)});
  } else if (!vdb) {
    checkNames(input, wanted, {"surface"});
  }
  if (surface && isWanted("surface", wanted)) result.grids.push_back({"surface", surfaceGrid(*result.shape)});
  if (result.grids.empty())
    throw GeometryError(name.path + ": there is nothing to slice" +
                        (result.notes.empty() ? "" : ": " + result.notes[0].sentence()));
  return result;
}

}  // namespace slicemorph
