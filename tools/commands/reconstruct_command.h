#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph reconstruct`. Its callback runs the command; errors are thrown.
void addReconstructCommand(CLI::App& program);

}  // namespace slicemorph
