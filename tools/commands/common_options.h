#pragma once

#include "io/input.h"
#include "slicemorph/conventions.h"
#include "slicemorph/note.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

/// What several commands share. The functions that check throw InputError naming the option, its value and
/// what would be right.
namespace slicemorph {

/// A number with at most `digits` significant digits, without trailing zeros.
std::string formatNumber(double value, int digits = 6);
/// As short as it can be read back.
std::string formatExactly(double value);

/// The choices are in the option's type already; the help need not list them twice.
CLI::Validator oneOf(std::vector<std::string> choices);

/// `--voxel-size`, `--resolution`, `--iso`, `--image` and `--spacing`.
struct SamplingOptions {
  CLI::Option* voxelSize;
  CLI::Option* resolution;
  CLI::Option* iso;
  CLI::Option* image;
  CLI::Option* spacing;
};
SamplingOptions addSamplingOptions(CLI::App& command, LoadOptions& options);
CLI::Option* addSpacingOption(CLI::App& command, ImageOptions& options);
void checkSampling(const LoadOptions& options, const SamplingOptions& given);

/// `--threads N`; `threads` 0: as many as the machine has.
CLI::Option* addThreadsOption(CLI::App& command, int& threads);
/// Limits TBB for as long as the result lives.
std::shared_ptr<void> limitThreads(int threads, const CLI::Option* given);

/// Numbers separated by commas.
std::vector<double> parseNumbers(const std::string& option, const std::string& text);
/// Names separated by commas, one at least.
std::vector<std::string> parseNames(const std::string& option, const std::string& text);
/// `x`, `y`, `z` or three numbers that are not all zero.
Vec3d parseDirection(const std::string& option, const std::string& text);
/// A whole number within limits.
void checkRange(const std::string& option, long value, long low, long high);
void checkPositive(const std::string& option, double value);

/// Throws IoError where an input (`file.vdb:grid` too) is missing or empty, so that a long job does not find
/// out late.
void checkInputExists(const std::string& input);
/// Writes a file whole or not at all. Throws IoError.
void writeTextFile(const std::string& path, const std::string& text);
/// Throws IoError where the folder of an output is not there or cannot be written to, or the path is a
/// folder.
void checkOutputPath(const std::string& path);
/// Throws InputError where the path's extension is none of those listed (lower case, with the dot).
void checkExtension(const std::string& path, const std::vector<std::string>& extensions);

/// Prints what was repaired or chosen, one line each, on stderr: `note: ABOUT...`, and `warning: ABOUT...`
/// where a note begins with `warning: `, by itself or after the file that it tells of.
void printNotes(const std::string& about, const Notes& notes, bool quiet);

}  // namespace slicemorph
