#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

namespace slicemorph {

/// Reads one volume (from 0) of a NIfTI file. Its position in space is the sform where that has a code and is
/// valid, else the qform, else the spacing alone; RAS is converted to LPS. Throws IoError, and InputError
/// where there is no such volume, and what `check` throws.
ImageFile readNifti(const std::string& path, int volume, const SizeCheck& check);

/// The same slice by slice, as openImageSlices.
std::optional<ImageSlices> openNifti(const std::string& path, int volume);

}  // namespace slicemorph
