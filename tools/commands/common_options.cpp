#include "tools/commands/common_options.h"

#include "io/atomic_file.h"
#include "io/output.h"
#include "io/paths.h"
#include "slicemorph/errors.h"

#include <tbb/global_control.h>
#include <unistd.h>

#include <algorithm>
#include <cerrno>
#include <cmath>
#include <cstdio>
#include <cstring>
#include <filesystem>
#include <sstream>

namespace slicemorph {

CLI::Validator oneOf(std::vector<std::string> choices) {
  CLI::Validator validator = CLI::IsMember(std::move(choices));
  validator.description("");
  return validator;
}

std::string formatNumber(double value, int digits) {
  char text[64];
  std::snprintf(text, sizeof text, "%.*g", digits, value);
  return text;
}

std::string formatExactly(double value) {
  for (int digits = 15; digits < 17; ++digits) {
    const std::string text = formatNumber(value, digits);
    if (std::strtod(text.c_str(), nullptr) == value) return text;
  }
  return formatNumber(value, 17);
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

std::vector<double> parseNumbers(const std::string& option, const std::string& text) {
  std::vector<double> numbers;
  size_t start = 0;
  while (start <= text.size()) {
    const size_t comma = std::min(text.find(',', start), text.size());
    const std::string part = text.substr(start, comma - start);
    size_t used = 0;
    double number = NAN;
    try {
      number = std::stod(part, &used);
    } catch (const std::exception&) {
    }
    if (used != part.size() || !std::isfinite(number))
      throw InputError(option + " " + text + ": '" + part +
                       "' is not a number; expected numbers separated by commas");
    numbers.push_back(number);
    start = comma + 1;
  }
  return numbers;
}

std::vector<std::string> parseNames(const std::string& option, const std::string& text) {
  std::vector<std::string> names;
  std::istringstream parts(text);
  for (std::string name; std::getline(parts, name, ',');) names.push_back(name);
  if (names.empty() || std::count(names.begin(), names.end(), ""))
    throw InputError(option + " " + text +
                     ": expected names separated by commas, for example density,temperature");
  return names;
}

Vec3d parseDirection(const std::string& option, const std::string& text) {
  const std::string letters = "xyz";
  if (text.size() == 1 && letters.find(text) != std::string::npos) {
    Vec3d axis(0, 0, 0);
    axis[int(letters.find(text))] = 1;
    return axis;
  }
  const std::string expected = "; expected x, y, z or DX,DY,DZ, for example 0,1,0.5";
  std::vector<double> numbers;
  try {
    numbers = parseNumbers(option, text);
  } catch (const InputError&) {
    throw InputError(option + " " + text + " is not a direction" + expected);
  }
  if (numbers.size() != 3) throw InputError(option + " " + text + " has not three numbers" + expected);
  const Vec3d direction(numbers[0], numbers[1], numbers[2]);
  if (direction.length() == 0) throw InputError(option + " " + text + " has no length" + expected);
  return direction;
}

void checkRange(const std::string& option, long value, long low, long high) {
  if (value < low || value > high)
    throw InputError(option + " " + std::to_string(value) + " is out of range; it must be " +
                     std::to_string(low) + " to " + std::to_string(high));
}

void checkPositive(const std::string& option, double value) {
  if (!(value > 0) || !std::isfinite(value))
    throw InputError(option + " " + formatNumber(value) + " must be a number above 0");
}

void checkInputExists(const std::string& input) { filesOfInput(input); }

void writeTextFile(const std::string& path, const std::string& text) {
  AtomicFile file(path);
  file.write(text);
  file.commit();
}

void checkOutputPath(const std::string& path) {
  namespace fs = std::filesystem;
  fs::path folder = fs::path(path).parent_path();
  if (folder.empty()) folder = ".";
  std::error_code error;
  if (fs::is_directory(path, error)) throw IoError(path + ": is a folder; the output must be a file");
  if (!fs::exists(folder, error)) throw IoError(path + ": the folder " + folder.string() + " does not exist");
  if (!fs::is_directory(folder, error)) throw IoError(path + ": " + folder.string() + " is not a folder");
  if (access(folder.c_str(), W_OK | X_OK) != 0)
    throw IoError(path + ": cannot write to the folder " + folder.string() + ": " + std::strerror(errno));
}

void checkExtension(const std::string& path, const std::vector<std::string>& extensions) {
  const std::string extension = OutputName(path).extension();
  if (std::find(extensions.begin(), extensions.end(), extension) != extensions.end()) return;
  std::string known;
  for (const std::string& e : extensions) known += (known.empty() ? "" : " ") + e;
  throw InputError(path + ": cannot write " +
                   (extension.empty() ? "a file without extension" : extension + " files") +
                   " here; expected " + known);
}

void printNotes(const std::string& about, const Notes& notes, bool quiet) {
  if (quiet) return;
  for (const Note& note : notes)
    std::fprintf(stderr, "%s: %s%s\n", note.severity == Severity::kWarning ? "warning" : "note",
                 about.c_str(), note.sentence().c_str());
}

}  // namespace slicemorph
