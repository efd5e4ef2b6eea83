#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// `slicemorph pick`: a page on which a user points at what belongs together.
void addPickCommand(CLI::App& program);

}  // namespace slicemorph
