#pragma once

#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Reads one volume (from 0) of an NRRD (.nrrd .nhdr) or MetaImage (.mha .mhd) file through ITK. Compressed
/// MetaImages are decompressed here, to the end of their stream: the size that their headers state may be
/// wrong, which a note reports. Throws IoError, and InputError where there is no such volume.
ImageFile readNrrd(const std::string& path, int volume);
ImageFile readMetaImage(const std::string& path, int volume);

}  // namespace slicemorph
