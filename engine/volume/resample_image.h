#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// An image at the voxels of another lattice, trilinear; beyond it its smallest value. Where voxels coincide
/// values are kept.
Image resampledTo(const Image& image, const ImageLattice& on);

/// A label map at the voxels of another lattice: that of the nearest voxel.
Image nearestTo(const Image& labels, const ImageLattice& on);

}  // namespace slicemorph
