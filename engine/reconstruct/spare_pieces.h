#pragma once

#include "engine/reconstruct/slice_gap.h"

namespace slicemorph {

/// Removes what a gap's slices have too much of: pieces of a label where a slice has more of them than either of the
/// gap's planes, and pieces that do not hang together, from slice to slice, with any piece on a plane. Each is joined to
/// another piece by a path of few pixels or goes to the labels around it, whichever costs less of the scores. A label
/// on both planes keeps a piece on every slice. `labels`: the pixels of gap `g`, a slice for each of `positions`.
void dropSparePieces(const SlicePlan& plan, size_t g, const std::vector<double>& positions,
                     std::vector<int>& labels);

}  // namespace slicemorph
