#pragma once

#include "engine/render/render.h"

#include <string>

namespace slicemorph {

/// Writes a picture as a float EXR (ZIP), channels R G B A, linear light, premultiplied. Throws IoError.
void writePictureExr(const std::string& path, const Picture& image);

}  // namespace slicemorph
