#pragma once

#include "tools/job/methods.h"

#include <vector>

namespace slicemorph {

/// Appends the methods that combine functions of space point by point, or frequency by frequency: rows of the table of
/// methods.
void addGridMethods(std::vector<MorphMethod>& table);

}  // namespace slicemorph
