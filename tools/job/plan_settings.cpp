#include "tools/job/plan_settings.h"

#include "tools/job/option_values.h"

namespace slicemorph {
namespace {

ContourPath pathOf(const std::string& name) {
  return name == "hermite"     ? ContourPath::kHermite
         : name == "intrinsic" ? ContourPath::kIntrinsic
                               : ContourPath::kLinear;
}

SpineKind spineOf(const std::string& name) {
  return name == "straight" ? SpineKind::kStraight : name == "curved" ? SpineKind::kCurved : SpineKind::kAuto;
}

/// Images state how they lie in space, so no turns about an upright axis are preferred.
Vec3d upOf(const JobOptions& given, bool images) {
  if (given.upright == "none" || (images && given.upright == "auto")) return Vec3d(0.0);
  const std::string axis = given.upright == "auto" ? given.glbUp : given.upright;
  return {axis == "x" ? 1.0 : 0.0, axis == "y" ? 1.0 : 0.0, axis == "z" ? 1.0 : 0.0};
}

}  // namespace

MorphOptions planSettings(const OptionSet& options, bool images) {
  const JobOptions& given = options.values();
  MorphOptions plan = given.plan;
  plan.voxelSize = given.load.voxelSize;
  plan.path = pathOf(given.interpolation);
  if (given.axis != "auto")
    plan.axis = options.about("axis", [&] { return parseDirection("--axis", given.axis); });
  plan.spine = spineOf(given.spine);
  plan.align = given.align == "none" ? Align::kNone : Align::kAuto;
  plan.up = upOf(given, images);
  return plan;
}

std::vector<Landmark> landmarksOf(const OptionSet& options, const std::string& name, const std::string& text,
                                  size_t inputs) {
  // --print-config reads no files.
  if (options.values().printConfig && text.find('=') == std::string::npos) return {};
  return options.about(name, [&] { return readLandmarks("--" + name, text, inputs); });
}

void checkIsos(const LoadOptions& load, const OptionSet& options, size_t inputs) {
  if (!load.isosByInput.empty() && load.isosByInput.size() != inputs)
    options.refuse("iso", "--iso names values for " + std::to_string(load.isosByInput.size()) +
                              " inputs of " + std::to_string(inputs) +
                              "; give one for all or one for each, for example --iso 300/250");
}

}  // namespace slicemorph
