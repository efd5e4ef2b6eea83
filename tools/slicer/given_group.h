#pragma once

#include "tools/slicer/slicer_module.h"

#include <initializer_list>

namespace slicemorph {

/// Options of `slicemorph reconstruct`, most of them on which slices are given.
inline ParameterGroup givenGroup(std::initializer_list<const char*> names) {
  ParameterGroup group{"Given slices", "Which slices were drawn is found, unless it is said here.", true, {}};
  for (const char* name : names) group.parameters.push_back(ofOption(kReconstruct, name));
  return group;
}

}  // namespace slicemorph
