#pragma once

#include "slicemorph/io/input_spec.h"
#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Makes each structure's surface or mask, a dense label map of all, or a file of structures, from contours. `input`: the file, and the
/// structure that was selected, if one was. Throws as reconstruct.
void reconstructContours(const ReconstructJob& job, const InputSpec& input, JobEvents& events);

}  // namespace slicemorph
