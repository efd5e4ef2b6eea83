#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

#include <optional>

namespace slicemorph {

/// Reads one volume (from 0; kNoVolume: the first) of a MetaImage (.mha .mhd), whose header is read by ITK; data in
/// one file are read here, to the end of their stream: the size that headers state may be wrong, which a note reports.
/// Values are scaled by ElementToIntensityFunctionSlope and Offset. Throws IoError, InputError where there is no such
/// volume, and what `check` throws.
ImageFile readMetaImage(const std::string& path, int volume, const ImageOptions& options,
                        const SizeCheck& check);

/// The same slice by slice, as openImageSlices.
std::optional<ImageSlices> openMetaImage(const std::string& path, int volume, const ImageOptions& options);

}  // namespace slicemorph
