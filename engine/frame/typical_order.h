#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// Indices of the objects, the one most similar to the mean of all first, comparing variances along
/// the principal axes and the radial distribution of volume. Depends on the shapes alone, not on the
/// order they are given in.
std::vector<size_t> typicalOrder(const Fields& fields);

}  // namespace slicemorph
