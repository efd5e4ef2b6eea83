#include "io/input_grids.h"

#include "engine/sections/object_boxes.h"
#include "engine/volume/image_grid.h"
#include "slicemorph/errors.h"
#include "slicemorph/io/output.h"

#include <algorithm>

namespace slicemorph {
namespace {

bool isWanted(const std::string& name, const std::vector<std::string>& wanted) {
  return wanted.empty() || std::find(wanted.begin(), wanted.end(), name) != wanted.end();
}

/// Adds the grids of a VDB that can be sliced and have voxels; where the input names a grid, that one alone.
/// `surface`: a grid `surface` will be added later, so the name is known.
void addVdb(const VdbFile& file, const InputSpec& input, const std::vector<std::string>& wanted, bool surface,
            char up, InputGrids& result) {
  result.metadata = file.metadata();
  std::string there = surface ? "surface" : "";
  std::vector<std::string> missing = wanted;
  if (!input.selection.empty()) missing.push_back(input.selection);
  missing.erase(std::remove(missing.begin(), missing.end(), surface ? "surface" : ""), missing.end());
  for (size_t i = 0; i < file.entries().size(); ++i) {
    const std::string& own = file.entries()[i].name;
    there += (there.empty() ? "" : ", ") + own;
    missing.erase(std::remove(missing.begin(), missing.end(), own), missing.end());
    if (!isWanted(own, wanted) || (!input.selection.empty() && own != input.selection)) continue;
    const openvdb::GridBase::ConstPtr header = file.readHeader(i);
    if (!header || !isSliceable(*header)) {
      result.notes.emplace_back("vdb.grid-left-out", Severity::kNote, "",
                                "grid '" + own + "' is left out: values of the type " +
                                    file.entries()[i].type + " cannot be sliced");
      continue;
    }
    const openvdb::GridBase::Ptr grid = placed(file.readDelayed(i), placingOf(input.placing, up));
    if (objectBoxes(*grid).empty()) {
      result.notes.emplace_back("vdb.grid-left-out", Severity::kNote, "",
                                "grid '" + own + "' is left out: it is empty");
      continue;
    }
    result.grids.push_back({own.empty() ? "value" : own, grid});
  }
  if (!missing.empty())
    throw InputError(input.path, "there is no grid '" + missing[0] + "'; there are " + there);
}

void checkNames(const std::string& input, const std::vector<std::string>& wanted,
                const std::vector<std::string>& there) {
  for (const std::string& name : wanted)
    if (std::find(there.begin(), there.end(), name) == there.end()) {
      std::string list;
      for (const std::string& known : there) list += (list.empty() ? "" : ", ") + known;
      throw InputError(input, "there is no grid '" + name + "'; there are " + list);
    }
}

/// `held`: the input where it is in memory; null: it is read.
InputGrids gridsOf(const InputSpec& input, const HeldInput* held, const std::vector<std::string>& wanted,
                   const LoadOptions& options, bool needsShape) {
  initialiseVdb();
  const bool image = input.isImage(), vdb = input.isGrids();
  const bool surface = (!image && !vdb) || options.isoGiven;
  InputGrids result;
  result.units = image ? "mm" : "world units";
  if (vdb) {
    const auto file = held ? std::get<std::shared_ptr<const VdbFile>>(held->content)
                           : std::make_shared<const VdbFile>(input.path);
    addVdb(*file, input, wanted, surface, options.image.up, result);
  }
  LoadedObject loaded;
  if (image || needsShape || (surface && isWanted("surface", wanted))) {
    loaded = held ? loadObject(*held, options) : loadObject(input, options);
    result.shape = loaded.object.levelSet;
    result.notes.insert(result.notes.end(), loaded.notes.begin(), loaded.notes.end());
  }
  if (image) {
    const std::string values = loaded.labels ? "labels" : "image";
    checkNames(input.text, wanted,
               surface ? std::vector<std::string>{values, "surface"} : std::vector<std::string>{values});
    if (isWanted(values, wanted))
      result.grids.push_back({values, gridOf(*loaded.image, values, loaded.labels)});
  } else if (!vdb) {
    checkNames(input.text, wanted, {"surface"});
  }
  if (surface && isWanted("surface", wanted)) result.grids.push_back({"surface", surfaceGrid(*result.shape)});
  if (result.grids.empty())
    throw GeometryError(input.path, "there is nothing to slice" +
                                        (result.notes.empty() ? "" : ": " + result.notes[0].sentence()));
  return result;
}

}  // namespace

InputGrids readInputGrids(const InputSpec& input, const std::vector<std::string>& wanted,
                          const LoadOptions& options, bool needsShape) {
  return gridsOf(stillInput(input), nullptr, wanted, options, needsShape);
}

InputGrids readInputGrids(const HeldInput& input, const std::vector<std::string>& wanted,
                          const LoadOptions& options, bool needsShape) {
  return gridsOf(input.spec, &input, wanted, options, needsShape);
}

}  // namespace slicemorph
