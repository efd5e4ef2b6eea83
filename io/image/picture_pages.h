#pragma once

#include "io/image/picture_plugin.h"

#include <string>

namespace slicemorph {

/// What the ImageDescription of a TIFF file says of its pages: ImageJ's lines `key=value`, OME's XML, tifffile's
/// `shape`. `resolution`: pixels per unit along x and y, 0 where the file has none. Throws std::runtime_error where a
/// description contradicts itself.
SlicemorphPages pagesFromDescription(const std::string& description, const double resolution[2]);

}  // namespace slicemorph
