#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph info`; its callback does the work and throws what is to be reported.
void addInfoCommand(CLI::App& program);

}  // namespace slicemorph
