#pragma once

#include "slicemorph/io/image_file.h"

#include <nifti/nifti2_io.h>

#include <string>

namespace slicemorph {

/// Sets the lattice's origin and steps, in LPS millimetres: of the sform where that has a code and is valid, else of the
/// qform, else of the voxel spacing alone; Analyze 7.5 by its `orient` and SPM's origin, which is told. So is a qform
/// that disagrees with the sform. Both are kept for what is written on the same voxels, and so is the time between
/// volumes. Throws IoError where the header has no valid affine and the options do not insist.
void placeNifti(const std::string& path, const nifti_image& header, const ImageOptions& options,
                ImageFile& file);

/// The header of an Analyze 7.5 file in the machine's byte order. Throws IoError where it is cut short.
nifti_analyze75 analyzeHeaderOf(const std::string& path);

}  // namespace slicemorph
