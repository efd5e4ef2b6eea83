#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Makes the dense map, or each label's surface, of a map whose labels were drawn on slices across two or three of its
/// axes. Returns false, and does nothing, where that is not so. Throws as reconstruct.
bool reconstructCross(const ReconstructJob& job, const Image& labels, const ImageHeader& header,
                      const Notes& before, JobEvents& events);

}  // namespace slicemorph
