#pragma once

#include <CLI/CLI.hpp>

namespace slicemorph {

/// `slicemorph survey`: all methods side by side on one page.
void addSurveyCommand(CLI::App& program);

}  // namespace slicemorph
