#pragma once

#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

namespace slicemorph {

/// Whether an output is one `.usda`, without ####.
bool isOneUsda(const std::string& output);
/// The VDB files beside a stage, in which its volume is: of `x.usda` `x.####.vdb`.
std::string vdbFilesOf(const std::string& usda);

/// Completes settings whose output is a `.usda`: how its stage lies in space and time, and, where it is to show a
/// volume, the VDB files beside it, which are then the output. Needs `inputs` and `output`. Throws InputError for
/// options that do not fit.
MorphSettings withUsd(MorphSettings settings, const OptionSet& options);

}  // namespace slicemorph
