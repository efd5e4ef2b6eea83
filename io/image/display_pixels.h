#pragma once

#include "engine/render/picture.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// 8-bit sRGB (IEC 61966-2-1), row by row. With `alpha` four bytes a pixel, alpha straight; else three, on
/// black. Values outside 0..1 are clipped, as 8 bits demand.
std::vector<std::uint8_t> displayPixels(const Picture& image, bool alpha);

}  // namespace slicemorph
