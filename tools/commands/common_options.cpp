#include "tools/commands/common_options.h"

#include "slicemorph/errors.h"

#include <tbb/global_control.h>

#include <cmath>
#include <cstdio>
#include <sstream>

namespace slicemorph {

CLI::Validator oneOf(std::vector<std::string> choices) {
  CLI::Validator validator = CLI::IsMember(std::move(choices));
  validator.description("");
  return validator;
}

SamplingOptions addSamplingOptions(CLI::App& command, LoadOptions& options) {
  SamplingOptions given;
  given.voxelSize =
      command.add_option("--voxel-size", options.voxelSize, "Edge of a voxel, world units")->type_name("H");
  given.resolution =
      command
          .add_option("--resolution", options.resolution,
                      "Voxels along the longest side of each object, 8 to 4096 (256 for meshes; VDB "
                      "inputs keep their voxel size)")
          ->type_name("N");
  given.iso = command
                  .add_option_function<std::string>(
                      "--iso",
                      [&options](const std::string& text) {
                        options.isosByInput.clear();
                        std::istringstream parts(text);
                        for (std::string part; std::getline(parts, part, '/');)
                          options.isosByInput.push_back(parseNumbers("--iso", part));
                        if (options.isosByInput.empty()) throw InputError("--iso needs a number");
                        options = optionsOfInput(options, 0);
                        options.isoGiven = true;
                        if (options.isosByInput.size() == 1) options.isosByInput.clear();
                      },
                      "Value of the surface in a VDB grid (0; in fog found from the density) or a grey image "
                      "(found from its "
                      "values); further ones of an image help to match; a slash parts those of one input "
                      "from the next's")
                  ->type_name("V[,V...][/V...]");
  given.image = command
                    .add_option_function<std::string>(
                        "--image",
                        [&options](const std::string& kind) {
                          options.imageKind = kind == "grey"     ? ImageKind::kGrey
                                              : kind == "labels" ? ImageKind::kLabels
                                                                 : ImageKind::kAuto;
                        },
                        "What an image's values are (auto: labels where whole numbers are mostly like their "
                        "neighbours)")
                    ->type_name("auto|grey|labels")
                    ->check(oneOf({"auto", "grey", "labels"}));
  given.spacing = addSpacingOption(command, options.image);
  return given;
}

CLI::Option* addSpacingOption(CLI::App& command, ImageOptions& options) {
  const auto parse = [&options](const std::string& text) {
    const std::vector<double> s = parseNumbers("--spacing", text);
    if (s.size() != 3 || !(s[0] > 0 && s[1] > 0 && s[2] > 0))
      throw InputError("--spacing " + text + ": expected three lengths above 0, X,Y,Z in millimetres");
    options.spacing = Vec3d(s[0], s[1], s[2]);
  };
  return command
      .add_option_function<std::string>(
          "--spacing", parse, "Of image stacks: pixel width, pixel height, gap between pictures, millimetres")
      ->type_name("X,Y,Z");
}

void checkSampling(const LoadOptions& options, const SamplingOptions& given) {
  const bool resolution = given.resolution && given.resolution->count();
  if (given.voxelSize->count() && resolution)
    throw InputError("--voxel-size and --resolution exclude each other; give one of them");
  if (given.voxelSize->count()) checkPositive("--voxel-size", options.voxelSize);
  if (resolution) checkRange("--resolution", options.resolution, 8, 4096);
  if (!std::isfinite(options.iso)) throw InputError("--iso must be a finite number");
}

CLI::Option* addThreadsOption(CLI::App& command, int& threads) {
  return command.add_option("--threads", threads, "Threads to use, 1 to 1024 (all; the result is the same)")
      ->type_name("N");
}

std::shared_ptr<void> limitThreads(int threads, const CLI::Option* given) {
  if (!given->count()) return nullptr;
  checkRange("--threads", threads, 1, 1024);
  return std::make_shared<tbb::global_control>(tbb::global_control::max_allowed_parallelism, size_t(threads));
}

void printNotes(const std::string& about, const Notes& notes, bool quiet) {
  if (quiet) return;
  for (const Note& note : notes)
    std::fprintf(stderr, "%s: %s%s\n", note.severity == Severity::kWarning ? "warning" : "note",
                 about.c_str(), note.sentence().c_str());
}

}  // namespace slicemorph
