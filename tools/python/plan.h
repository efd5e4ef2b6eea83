#pragma once

#include <pybind11/pybind11.h>

namespace slicemorph {

/// Plans and their frames.
void addPlan(pybind11::module_& module);

}  // namespace slicemorph
