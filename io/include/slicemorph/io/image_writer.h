#pragma once

#include "slicemorph/image.h"

#include <string>

namespace slicemorph {

/// Whether an output is an image by its extension: .nii .nii.gz .nrrd .mha.
bool isImageOutput(const std::string& path);

/// Writes an image whole or not at all, with its own value type, compressed unless .nii; LPS is converted to
/// the format's axes. NIfTI gets an sform, and a qform where the axes are at right angles. The same bytes for
/// any thread count. Throws InputError for another extension, and IoError.
void writeImage(const std::string& path, const Image& image);

}  // namespace slicemorph
