#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// `slicemorph retime`: a sequence at another speed, with frames between its files.
void addRetimeCommand(CLI::App& program);

}  // namespace slicemorph
