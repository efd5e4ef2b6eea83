#pragma once

#include "engine/slicemorph.h"
#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"

namespace slicemorph {

using Fields = std::vector<std::shared_ptr<const DistanceField>>;

struct Frames {
  std::vector<Chart> charts;       ///< one per object
  double halfLength = 1;           ///< the common half length along the spine, chart units
  std::vector<std::string> notes;  ///< what was decided
};

/// Gives every object its chart so that like lies on like: oriented bounding boxes from the moments of the inside, the
/// 24 proper axis assignments, the world's own axes and small turns, scored by the overlap of the aligned shapes less
/// a small price on the turning angle. Symmetric in the objects' order for two of them.
Frames alignFrames(const Fields& fields, const MorphOptions& options);

}  // namespace slicemorph
