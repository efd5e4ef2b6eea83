#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph convert`. Its callback runs the command; errors are thrown.
void addConvertCommand(CLI::App& program);

}  // namespace slicemorph
