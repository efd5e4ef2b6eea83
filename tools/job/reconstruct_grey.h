#pragma once

#include "slicemorph/io/image_file.h"
#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Makes the dense image of a grey stack, or of an image whose slices between the given ones are empty. Throws as
/// reconstruct.
void reconstructGrey(const ReconstructJob& job, ImageFile file, JobEvents& events);

}  // namespace slicemorph
