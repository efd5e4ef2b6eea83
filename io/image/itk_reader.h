#pragma once

#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Reads one volume (from 0) of an NRRD (.nrrd .nhdr) or MetaImage (.mha .mhd) file through ITK. Compressed
/// MetaImages are unpacked here, to the end of their stream: their headers may state a wrong size, which is
/// repaired with a note. Throws IoError, and InputError where there is no such volume.
ImageFile readNrrd(const std::string& path, int volume);
ImageFile readMetaImage(const std::string& path, int volume);

}  // namespace slicemorph
