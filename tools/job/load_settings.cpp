#include "tools/job/load_settings.h"

#include "tools/job/option_values.h"

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

}  // namespace

LoadOptions loadSettings(const OptionSet& options) {
  const JobOptions& given = options.values();
  LoadOptions load = given.load;
  if (!given.iso.empty()) load = options.about("iso", [&] { return withIsos(load, given.iso); });
  load.imageKind = given.imageKind == "grey"     ? ImageKind::kGrey
                   : given.imageKind == "labels" ? ImageKind::kLabels
                                                 : ImageKind::kAuto;
  if (!given.spacing.empty())
    load.image.spacing = options.about("spacing", [&] { return parseSpacing(given.spacing); });
  return load;
}

}  // namespace slicemorph
