#pragma once

#include "slicemorph/io/input.h"
#include "slicemorph/note.h"
#include "tools/job/option_values.h"

#include <CLI/CLI.hpp>

#include <memory>
#include <string>
#include <vector>

/// What several commands share.
namespace slicemorph {

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

/// Prints what was repaired or chosen, one line each, on stderr: `note: ABOUT...`, and `warning: ABOUT...`
/// where a note begins with `warning: `, by itself or after the file that it tells of.
void printNotes(const std::string& about, const Notes& notes, bool quiet);

}  // namespace slicemorph
