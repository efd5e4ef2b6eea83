#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Of EXR slices: all grids into a `.vdb`, the one of a surface into a mesh, the one of values into an image.
void reconstructSlices(const ReconstructJob& job, JobEvents& events);

}  // namespace slicemorph
