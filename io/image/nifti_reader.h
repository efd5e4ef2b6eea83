#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

#include <optional>

namespace slicemorph {

/// Reads one volume (from 0; kNoVolume: the first, or the luminance of colours) of a NIfTI-1, NIfTI-2 or Analyze 7.5
/// file, plain or by gzip, header and data together or apart. Where it lies: see placeNifti(). Throws IoError, and
/// InputError where there is no such volume, and what `check` throws.
ImageFile readNifti(const std::string& path, int volume, const ImageOptions& options, const SizeCheck& check);

/// The same slice by slice, as openImageSlices.
std::optional<ImageSlices> openNifti(const std::string& path, int volume, const ImageOptions& options);

}  // namespace slicemorph
