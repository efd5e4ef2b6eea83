#pragma once

#include "engine/reconstruct/slice_gap.h"

namespace slicemorph {

/// Joins regions of the planes around gap `g` to the rest of their label by one pixel, where without it they would touch
/// none of it in the gap and with it do. Such pixels are taken from labels after it only, as near ties are. `labels`: the
/// pixels of the gap, a slice for each of `positions`.
void joinPieces(const SlicePlan& plan, size_t g, const std::vector<double>& positions,
                std::vector<int>& labels);

}  // namespace slicemorph
