#pragma once

#include "tools/slicer/slicer_module.h"

#include <string>

namespace slicemorph {

/// The description of a module that Slicer asks for by --xml: the Slicer Execution Model, version of Slicer 5.
std::string xmlOf(const SlicerModule& module);

}  // namespace slicemorph
