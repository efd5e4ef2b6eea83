#pragma once

#include "tools/job/morph_settings.h"
#include "tools/job/option_set.h"

/// What options of `morph` cannot go together. Everything throws InputError naming the option, its value and
/// what would be right, with the place where a job file says it.
namespace slicemorph {

/// Inputs, an output, and no two options that exclude each other: what the rest is read by.
void checkEssentials(const OptionSet& options);
/// All options that are given are for this method and this kind of output, as the table says.
void checkPurposes(const MorphSettings& settings, const OptionSet& options);
/// The output can hold what the inputs and the method give.
void checkOutputKind(const MorphSettings& settings, const OptionSet& options);
/// The method takes these inputs and frames.
void checkMethodInputs(const MorphSettings& settings, const OptionSet& options);
/// Inputs are there, and all outputs can be written. Throws IoError, too.
void checkMorphFiles(const MorphSettings& settings, const OptionSet& options);

/// Files of the longest input that is a sequence; 1 where none is, and where files are not to be looked at.
size_t lengthOfInputs(const OptionSet& options);

}  // namespace slicemorph
