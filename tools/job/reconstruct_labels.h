#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Makes the dense map, or each label's surface, from a label map with empty slices or a stack of slices; of a grey image
/// a dense one.
/// Throws as reconstruct.
void reconstructImage(const ReconstructJob& job, JobEvents& events);

}  // namespace slicemorph
