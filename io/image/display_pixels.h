#pragma once

#include "engine/render/picture.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// 8-bit sRGB (IEC 61966-2-1) pixels, row by row: with `alpha` RGBA with straight alpha, else RGB over black.
/// Values outside 0..1 are clipped, as 8 bits demand.
std::vector<std::uint8_t> displayPixels(const Picture& image, bool alpha);

}  // namespace slicemorph
