#pragma once

#include "tools/job/option_set.h"

#include <string>

namespace slicemorph {

/// Reads a TOML job file of `key = value` lines and gives its values, and where they are said, to the options
/// that nothing has set yet and that nothing silences. kNumbers takes a number, several, which are joined by
/// commas, or a text; kTexts also a single text; kPlaces a text, or a list of lists of x,y,z, joined as
/// "x,y,z=x,y,z;...". Throws IoError where the file cannot be read, InputError for syntax errors, unknown keys
/// and wrong values, with the place.
void applyJobFile(const std::string& path, OptionSet& options);

}  // namespace slicemorph
