#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph morph`. Its callback runs the command; errors are thrown.
void addMorphCommand(CLI::App& program);

}  // namespace slicemorph
