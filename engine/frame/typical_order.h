#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// Numbers of the objects, those first that are most like the mean of all: in volume's spread along its axes
/// and away from its middle. It follows from the shapes alone, in whatever order they are given, and costs as
/// much for each.
std::vector<size_t> typicalOrder(const Fields& fields);

}  // namespace slicemorph
