#pragma once

#include "engine/reconstruct/slice_gap.h"

namespace slicemorph {

/// As SliceScores::labelsBetween: the label of highest score for every pixel at positions within one gap.
/// Cells of pixels are halved until only one label can win in a cell, or until the cell is small enough to
/// evaluate every pixel.
std::vector<int> labelsInGap(const SlicePlan& plan, const std::vector<double>& positions);

}  // namespace slicemorph
