#pragma once

#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Reads one volume (from 0) of a NIfTI file: the sform where it has a code, else the qform, else spacing
/// alone; RAS made LPS. Throws IoError, and InputError where there is no such volume.
ImageFile readNifti(const std::string& path, int volume);

}  // namespace slicemorph
