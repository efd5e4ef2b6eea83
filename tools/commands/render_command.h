#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// Adds `slicemorph render`. Its callback runs the command; errors are thrown.
void addRenderCommand(CLI::App& program);

}  // namespace slicemorph
