#pragma once

#include "tools/job/option_set.h"

#include <CLI/CLI.hpp>

#include <memory>

namespace slicemorph {

/// A subcommand with the options that the table gives it, checked as they are parsed, and with their help by
/// groups: `--help` the usual ones, `--help-all` every one. The set outlives the parsing.
std::shared_ptr<OptionSet> addOptions(CLI::App& command, Command which);

}  // namespace slicemorph
