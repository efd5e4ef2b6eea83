#pragma once

#include <pybind11/pybind11.h>

namespace slicemorph {

/// Lets the library's exceptions arrive in Python as the classes of slicemorph/_errors.py, with the fields of their notes.
void addErrors();

}  // namespace slicemorph
