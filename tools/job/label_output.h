#pragma once

#include "tools/job/reconstruct.h"

namespace slicemorph {

/// Writes a dense label map, on the voxels of --like where it is given: as one image, with #### in the name as a mask
/// of each label, or as structures; and its reports. `header`: of the input's file, whose names of labels structures get;
/// `notes`: for the reports. Throws as reconstruct.
void writeLabelImage(const ReconstructJob& job, Image dense, ImageHeader header, const Notes& notes,
                     JobEvents& events);

}  // namespace slicemorph
