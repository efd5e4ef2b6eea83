#pragma once

#include "tools/job/option_set.h"

#include <string>

namespace slicemorph {

/// Reads a TOML job file of `key = value` lines. Sets the options that are neither set nor silenced by the
/// command line, and remembers for each its position in the file. kNumbers takes a number, a list of numbers,
/// which are joined by commas, or a text; kTexts also a single text; kLandmarks a text, or a list of lists of
/// x,y,z, joined as "x,y,z=x,y,z;...". Throws IoError where the file cannot be read; InputError for syntax
/// errors, unknown keys and wrong values, with `file:line:column`.
void applyJobFile(const std::string& path, OptionSet& options);

}  // namespace slicemorph
