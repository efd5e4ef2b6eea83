#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph info`. Its callback runs the command; errors are thrown.
void addInfoCommand(CLI::App& program);

}  // namespace slicemorph
