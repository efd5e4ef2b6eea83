#pragma once

#include <CLI/CLI.hpp>

#include <string>

namespace slicemorph {

/// Writes the man pages of the program and of its commands (`slicemorph.1`, `slicemorph-morph.1`, ...) and the completion
/// for bash (`slicemorph.bash`) into a folder, which is made. All is taken from the commands' options. Throws IoError.
void writeManual(const CLI::App& program, const std::string& folder);

}  // namespace slicemorph
