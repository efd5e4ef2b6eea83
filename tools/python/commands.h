#pragma once

#include <pybind11/pybind11.h>

namespace slicemorph {

/// The program's commands, with results in memory where these fit in there, and the table of their options.
void addCommands(pybind11::module_& module);

}  // namespace slicemorph
