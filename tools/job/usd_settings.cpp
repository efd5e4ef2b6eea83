#include "tools/job/usd_settings.h"

#include "io/paths.h"
#include "slicemorph/io/input_spec.h"

namespace slicemorph {
namespace {

UsdaStage stageOf(const MorphSettings& s, const OptionSet& options) {
  const JobOptions& given = options.values();
  // Images are in millimetres, and their z points up, but for what was said.
  const bool images = s.allImages();
  const std::string up = images && !options.given("glb-up") ? "z" : given.glbUp;
  const std::string unit = images && !options.given("glb-unit") ? "mm" : given.unit;
  return {given.framesPerSecond, unit == "mm" ? 1e-3 : unit == "cm" ? 1e-2 : 1, up == "z"};
}

bool showsVolume(const MorphSettings& s, const OptionSet& options) {
  const std::string& usd = options.values().usd;
  const bool sequence = OutputName(s.output).isSequence();
  if (usd == "volume" && sequence)
    options.refuse("usd", "--usd volume: a .usda of a volume holds all frames; leave the #### out of -o " +
                              s.output + ", or ask for --usd mesh");
  if (usd != "auto") return usd == "volume";
  bool meshes = true;
  for (size_t k = 0; k < s.inputs.size(); ++k) meshes = meshes && s.input(k).contents == Contents::kMesh;
  return !sequence && !meshes;
}

/// A mesh's velocities are those of USD, per second, and the map's.
void checkMeshVelocity(const OptionSet& options) {
  for (const char* name : {"velocity-unit", "velocity-half", "add-velocity"})
    if (options.given(name))
      options.refuse(name, std::string("--") + name +
                               " is for velocities in grids; the mesh of a .usda has the morph's own, per "
                               "second (--usd volume has grids)");
}

}  // namespace

bool isOneUsda(const std::string& output) {
  const OutputName name(output);
  return name.extension() == ".usda" && !name.isSequence();
}

std::string vdbFilesOf(const std::string& usda) {
  return usda.substr(0, usda.size() - extensionOf(usda).size()) + ".####.vdb";
}

MorphSettings withUsd(MorphSettings s, const OptionSet& options) {
  if (OutputName(s.output).extension() != ".usda") {
    if (options.given("usd"))
      options.refuse("usd",
                     "--usd " + options.values().usd + " is for outputs that are .usda, not for " + s.output);
    return s;
  }
  s.stage = stageOf(s, options);
  if (showsVolume(s, options)) {
    s.usdVolume = s.output;
    s.output = vdbFilesOf(s.output);
  } else {
    checkMeshVelocity(options);
  }
  return s;
}

}  // namespace slicemorph
