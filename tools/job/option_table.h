#pragma once

#include "tools/job/option_row.h"

#include <vector>

namespace slicemorph {

/// One table of what can be told to the commands. From it come the command line, its help, the keys of job
/// files, --print-config and what --resume compares. A new option is a row here, a field for it to be bound to
/// (job_options.h, or a struct in there), and the place that uses the field.
/// A command has no two rows of one name; rows are in the order of the help.
const std::vector<OptionRow>& optionTable();

}  // namespace slicemorph
