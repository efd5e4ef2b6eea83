#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Makes grids from EXR slices: all into a `.vdb`, or one into a mesh or an image. Throws as reconstruct.
void reconstructSlices(const ReconstructJob& job, JobEvents& events);

}  // namespace slicemorph
