#pragma once

#include "engine/numerics/pixel_box.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// Signed distances, positive inside, from each pixel's centre to the nearest centre of the other side, less
/// half the shorter pixel side, so that contours run between pixels ([FH12]: exact, linear in the number of
/// pixels). `mask`: box.count() values, row by row. `stepX`, `stepY`: the pixel's sides. `far`: distance to
/// use if one side is empty.
std::vector<float> maskDistance(const std::vector<std::uint8_t>& mask, const PixelBox& box, float stepX,
                                float stepY, float far);

}  // namespace slicemorph
