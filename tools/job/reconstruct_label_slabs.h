#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Makes the dense map slice by slice where it would not fit --memory: the same bytes as in memory. Returns false, and
/// does nothing, where it fits, or cannot be made so: for reports and --like, and inputs that are not read slice by
/// slice. Throws as reconstruct, and MemoryError where slices follow each other along another axis than k.
bool reconstructLabelSlabs(const ReconstructJob& job, JobEvents& events);

}  // namespace slicemorph
