#pragma once

#include "tools/job/option_set.h"

#include <CLI/CLI.hpp>

#include <memory>

namespace slicemorph {

/// Adds the table's options to a subcommand, checked as they are parsed, with their help by groups: `--help`
/// shows the basic ones, `--help-all` all. Returns the set that parsing fills.
std::shared_ptr<OptionSet> addOptions(CLI::App& command, Command which);

/// The options that addOptions added.
const OptionSet& optionsOf(const CLI::App& command);

}  // namespace slicemorph
