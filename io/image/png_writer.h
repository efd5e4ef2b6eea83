#pragma once

#include "engine/render/picture.h"

#include <string>

namespace slicemorph {

/// The bytes that writePng writes. Throws IoError.
std::string encodePng(const Picture& image);

/// Writes an 8-bit sRGB PNG: RGB where alpha is 1 everywhere, else RGBA with straight alpha. Values outside
/// 0..1 are clipped, as the format demands. The file appears whole or not at all. Throws IoError.
void writePng(const std::string& path, const Picture& image);

}  // namespace slicemorph
