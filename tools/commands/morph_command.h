#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph morph`; its callback does the work and throws what is to be reported.
void addMorphCommand(CLI::App& program);

}  // namespace slicemorph
