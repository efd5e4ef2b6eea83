#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph render`; its callback does the work and throws what is to be reported.
void addRenderCommand(CLI::App& program);

}  // namespace slicemorph
