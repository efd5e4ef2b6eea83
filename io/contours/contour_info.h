#pragma once

#include "io/contours/contour_reader.h"
#include "slicemorph/io/file_info.h"

namespace slicemorph {

/// What structures hold. Each plane stands for a slab that reaches half way to its neighbours, and as far beyond the
/// outermost ones; loops within loops are holes (even-odd rule).
std::vector<StructureInfo> describeStructures(const std::vector<ContourSet>& sets);

}  // namespace slicemorph
