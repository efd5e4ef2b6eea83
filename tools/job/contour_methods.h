#pragma once

#include "tools/job/methods.h"

#include <vector>

namespace slicemorph {

/// Appends the methods that move matched points of surfaces and contours along paths: rows of the table of methods.
void addContourMethods(std::vector<MorphMethod>& table);

}  // namespace slicemorph
