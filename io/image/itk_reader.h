#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"
#include "slicemorph/io/image_slices.h"

namespace slicemorph {

/// Reads one volume (from 0) of an NRRD (.nrrd .nhdr) or MetaImage (.mha .mhd) file through ITK. Compressed
/// MetaImages are decompressed here, to the end of their stream: the size that their headers state may be
/// wrong, which a note reports. Throws IoError, InputError where there is no such volume, and what `check` throws.
ImageFile readNrrd(const std::string& path, int volume, const SizeCheck& check);
ImageFile readMetaImage(const std::string& path, int volume, const SizeCheck& check);

/// The same slice by slice, as openImageSlices.
std::optional<ImageSlices> openNrrd(const std::string& path, int volume);
std::optional<ImageSlices> openMetaImage(const std::string& path, int volume);

}  // namespace slicemorph
