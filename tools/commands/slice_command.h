#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph slice`. Its callback runs the command; errors are thrown.
void addSliceCommand(CLI::App& program);

}  // namespace slicemorph
