#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph demo`. Its callback runs the command; errors are thrown.
void addDemoCommand(CLI::App& program);

}  // namespace slicemorph
