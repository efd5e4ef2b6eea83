#include "tools/job/load_settings.h"

#include "slicemorph/io/output.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>
#include <sstream>

namespace slicemorph {
namespace {

/// Parses `V,V/V`: iso values separated by commas, the surface's first; by slashes those of each input.
LoadOptions withIsos(LoadOptions load, const std::string& text) {
  load.isosByInput.clear();
  std::istringstream parts(text);
  for (std::string part; std::getline(parts, part, '/');)
    load.isosByInput.push_back(parseNumbers("--iso", part));
  load = optionsOfInput(load, 0);
  load.isoGiven = true;
  if (load.isosByInput.size() == 1) load.isosByInput.clear();
  return load;
}

Vec3d parseSpacing(const std::string& text) {
  const std::vector<double> s = parseNumbers("--spacing", text);
  if (s.size() != 3 || !(s[0] > 0 && s[1] > 0 && s[2] > 0))
    throw InputError("--spacing " + text + ": expected three lengths above 0, X,Y,Z in millimetres");
  return {s[0], s[1], s[2]};
}

/// Throws InputError where braces ask to fit an input to the first one and the command has none: only morph does.
void checkFits(const OptionSet& options) {
  const JobOptions& given = options.values();
  const auto& rows = options.rows();
  const bool fits =
      std::any_of(rows.begin(), rows.end(), [](const OptionRow* row) { return row->name == "fit"; });
  std::vector<std::string> names = fits ? std::vector<std::string>() : given.inputs;
  names.insert(names.end(), {given.input, given.other, given.like});
  for (const std::string& name : names)
    if (!name.empty() && !parseInput(name).placing.fit.empty())
      throw InputError(name +
                       ": fit= brings an input of morph to its first one, and here is none; scale= and "
                       "upright= work everywhere");
}

/// Of what is free when the program starts; the rest is for others.
constexpr double kShareOfFree = 0.8;
/// Least memory that may be asked for: the program with its libraries and threads takes 50 to 80 MB before it holds anything,
/// and where threads cannot start it cannot even say so.
constexpr double kLeastMemory = 100 * 1024.0 * 1024.0;

}  // namespace

MemoryLimit memorySettings(const OptionSet& options) {
  const std::string& said = options.values().memory;
  const double free = freeMemory();
  MemoryLimit limit;
  if (!said.empty())
    limit.bytes = options.about("memory", [&] {
      const double bytes = parseBytes("--memory", said, free);
      if (bytes < kLeastMemory)
        throw InputError("--memory " + said + ": is " + describeBytes(bytes) +
                         ", about what the program takes without any input; give it 100M or more");
      return bytes;
    });
  else if (std::isfinite(free))
    limit.bytes = kShareOfFree * free + takenMemory();
  return limit;
}

MeshSpace meshSpace(const OptionSet& options, const std::string& output, MeshSpace otherwise) {
  const std::string& space = options.values().space;
  if (space == "auto") return otherwise;
  const std::string meshes = writableList(Contents::kMesh) + " ";
  const std::string extension = OutputName(output).extension();
  if (extension == ".glb" || extension == ".usda" || meshes.find(extension + " ") == std::string::npos)
    throw InputError("--space " + space + " is for meshes that can say it (.stl .ply .obj .vtp); " + output +
                     " is none");
  return space == "RAS" ? MeshSpace::kRas : MeshSpace::kLps;
}

LoadOptions loadSettings(const OptionSet& options) {
  checkFits(options);
  const JobOptions& given = options.values();
  LoadOptions load = given.load;
  const std::string up = given.upright == "auto" ? given.glbUp : given.upright;
  load.image.up = up == "x" || up == "z" ? up[0] : 'y';
  load.memory = load.image.memory = memorySettings(options);
  if (!given.iso.empty()) load = options.about("iso", [&] { return withIsos(load, given.iso); });
  load.imageKind = given.imageKind == "grey"     ? ImageKind::kGrey
                   : given.imageKind == "labels" ? ImageKind::kLabels
                                                 : ImageKind::kAuto;
  load.image.force = given.force;
  if (!given.spacing.empty())
    load.image.spacing = options.about("spacing", [&] { return parseSpacing(given.spacing); });
  return load;
}

}  // namespace slicemorph
