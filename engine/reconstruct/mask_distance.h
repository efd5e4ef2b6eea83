#pragma once

#include "engine/reconstruct/pixel_box.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// Signed distances, positive inside, of a mask's pixels' centres to the edges of the nearest pixels of the other side:
/// half a step next to the border, so that contours run between the pixels. Exact in which pixel is nearest (its centre;
/// Felzenszwalb & Huttenlocher 2012), linear in the pixels. `mask`: box.count() values, row by row; `stepX`, `stepY`: the
/// pixel's sides, `far`: the distance where one side is empty.
std::vector<float> maskDistance(const std::vector<std::uint8_t>& mask, const PixelBox& box, float stepX, float stepY,
                                float far);

}  // namespace slicemorph
