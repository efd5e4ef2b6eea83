#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph compare`. Its callback runs the command; errors are thrown.
void addCompareCommand(CLI::App& program);

}  // namespace slicemorph
