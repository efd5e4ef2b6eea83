#pragma once

#include "engine/rebuild/warp_image.h"

namespace slicemorph {

/// Whether all images are the same one at the same, known isovalue: then every in-between is that image.
bool allSame(const std::vector<CarriedImage>& images);

/// The in-between of images where nothing moves: sum_k w_k V_k at each voxel, of the first image alone where the others
/// have its value. So images that are equal are themselves to the bit.
Image blendStill(const std::vector<CarriedImage>& images, const ImageLattice& on);

}  // namespace slicemorph
