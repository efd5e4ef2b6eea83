#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph apply` to the program.
void addApplyCommand(CLI::App& program);

}  // namespace slicemorph
