#pragma once

#include "engine/reconstruct/slice_gap.h"

namespace slicemorph {

/// As SliceScores::labelsBetween: the labels of highest score of all pixels at positions inside one gap. Cells of pixels
/// are halved until one label alone may win there, or so few are left that they are looked at one by one.
std::vector<int> labelsInGap(const SlicePlan& plan, const std::vector<double>& positions);

}  // namespace slicemorph
