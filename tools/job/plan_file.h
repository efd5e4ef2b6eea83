#pragma once

#include "slicemorph/note.h"
#include "tools/job/option_set.h"

#include <string>
#include <utility>
#include <vector>

namespace slicemorph {

/// A plan on disk, by which frames are made at once, in any order, on any machine that has the inputs: a line that names
/// the format, a line of JSON, and the compressed decisions.
struct PlanFile {
  std::string program;  ///< version and build that made it
  size_t frame = 0;     ///< of inputs that are sequences: of which of their frames it is, from 0
  /// Options on which the plan depends and that were given, with their texts; files by their whole paths.
  std::vector<std::pair<std::string, std::vector<std::string>>> options;
  std::string decisions;  ///< see MorphPlan::decisions
};

/// The options of `morph` on which plans depend, among those that are given.
PlanFile planFileOf(const OptionSet& options);

/// Whole or not at all. Throws IoError.
void writePlanFile(const std::string& path, const PlanFile& plan);

/// Throws IoError for what is no plan, is damaged, or is of another version of the format.
PlanFile readPlanFile(const std::string& path);

/// Of a numbered sequence of plans the number that the plan of the inputs' first frame has, or would have, by the first
/// file that is there. Throws IoError as readPlanFile.
int firstPlanNumber(const std::string& name);

/// Sets the options of the plan named by --plan, where there is one; of a numbered sequence of plans those of the first
/// file that is there. Objects that were given stay, as they may have moved; `beside`: the number of inputs that are no
/// objects and come behind them. Throws InputError where another option was given with another value than the plan's;
/// IoError as readPlanFile, and for a plan made with options that the command does not have.
Notes applyPlanFile(OptionSet& options, size_t beside = 0);

}  // namespace slicemorph
