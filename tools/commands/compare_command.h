#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph compare`; its callback does the work and throws what is to be reported.
void addCompareCommand(CLI::App& program);

}  // namespace slicemorph
