#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// `slicemorph plan`: what `morph` decides before it makes frames, as a file.
void addPlanCommand(CLI::App& program);

}  // namespace slicemorph
