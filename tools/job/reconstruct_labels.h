#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Of a label map in which slices are empty, or a stack of slices: the dense map, or each label's surface.
void reconstructLabels(const ReconstructJob& job, JobEvents& events);

}  // namespace slicemorph
