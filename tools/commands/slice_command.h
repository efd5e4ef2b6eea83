#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph slice`; its callback does the work and throws what is to be reported.
void addSliceCommand(CLI::App& program);

}  // namespace slicemorph
