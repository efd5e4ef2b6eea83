#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph reconstruct`; its callback does the work and throws what is to be reported.
void addReconstructCommand(CLI::App& program);

}  // namespace slicemorph
