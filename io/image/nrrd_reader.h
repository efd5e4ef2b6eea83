#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

#include <optional>

namespace slicemorph {

/// Reads one volume (from 0; kNoVolume: the first, or the luminance of colours) of an NRRD file (.nrrd .nhdr), whose
/// header is read by Teem's own library. Throws IoError, InputError where there is no such volume, and what `check`
/// throws.
ImageFile readNrrd(const std::string& path, int volume, const ImageOptions& options, const SizeCheck& check);

/// The same slice by slice, as openImageSlices.
std::optional<ImageSlices> openNrrd(const std::string& path, int volume, const ImageOptions& options);

}  // namespace slicemorph
