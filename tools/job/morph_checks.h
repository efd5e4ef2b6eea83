#pragma once

#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

/// Checks the options of `morph` against each other. Everything throws InputError naming the option, its
/// value and what would be right, with its position if a job file gives it.
namespace slicemorph {

/// Inputs and an output are given, and no two options that exclude each other.
void checkEssentials(const OptionSet& options);
/// All options that are given have an effect with this method and this kind of output, by the table.
void checkPurposes(const MorphSettings& settings, const OptionSet& options);
/// The output can hold what inputs and method yield.
void checkOutputKind(const MorphSettings& settings, const OptionSet& options);
/// The method takes these inputs and frames.
void checkMethodInputs(const MorphSettings& settings, const OptionSet& options);
/// Inputs exist and all outputs can be written. Also throws IoError.
void checkMorphFiles(const MorphSettings& settings, const OptionSet& options);

/// Number of files of the longest input that is a sequence; 1 where none is, and with --print-config, which
/// reads no files.
size_t lengthOfInputs(const OptionSet& options);

}  // namespace slicemorph
