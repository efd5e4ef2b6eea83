#pragma once

#include "engine/numerics/pixel_box.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// Signed distances, positive inside, of a mask's pixels' centres to the nearest centre of the other side,
/// less half the shorter step, so that contours run between the pixels ([FH12]:
/// exact, linear in the pixels). `mask`: box.count() values, row by row; `stepX`, `stepY`: the pixel's sides,
/// `far`: the distance where one side is empty.
std::vector<float> maskDistance(const std::vector<std::uint8_t>& mask, const PixelBox& box, float stepX,
                                float stepY, float far);

}  // namespace slicemorph
