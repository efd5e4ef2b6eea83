#pragma once

#include "tools/job/option_row.h"

#include <vector>

namespace slicemorph {

/// The table of the options of all commands. Command line, help, keys of job files, --print-config and what
/// --resume compares are made from it. A new option needs a row here, a field that it is bound to (in
/// job_options.h or a struct used there) and code that uses the field. No command has two rows of one name;
/// rows are in the order of the help.
const std::vector<OptionRow>& optionTable();

}  // namespace slicemorph
