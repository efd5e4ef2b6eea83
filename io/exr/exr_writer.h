#pragma once

#include "engine/render/picture.h"

#include <string>

namespace slicemorph {

/// Writes a picture as an EXR (ZIP) in linear light: `R G B A`, premultiplied, and of the further channels
/// those that it has: `mask`, `Z` (depth along the axis of view, world units; 1e10 where there is nothing)
/// and `N.X N.Y N.Z` (world normal, 0 where there is nothing). Depth is float, the others half. The camera is in
/// the attributes `worldToCamera` and `worldToNDC`, as renderers write them and compositors'
/// scripts take them: the latter goes to -1 .. 1, y up, and not to the 0 .. 1, y down, of OpenEXR's comments. The file
/// appears whole or not at all. Throws IoError.
void writePictureExr(const std::string& path, const Picture& image);

}  // namespace slicemorph
