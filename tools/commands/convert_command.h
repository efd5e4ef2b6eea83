#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph convert`; its callback does the work and throws what is to be reported.
void addConvertCommand(CLI::App& program);

}  // namespace slicemorph
