#pragma once

#include "slicemorph/io/input_spec.h"
#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Of contours: each structure's surface, or a dense label map of all. `input`: the file, and the
/// structure that was chosen.
void reconstructContours(const ReconstructJob& job, const InputSpec& input, JobEvents& events);

}  // namespace slicemorph
