#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// An image resampled at the voxels of another lattice, trilinear; outside the image its lowest value. Exact
/// where voxels coincide.
Image resampledTo(const Image& image, const ImageLattice& on);

/// A label map at the voxels of another lattice: the nearest voxel's label, 0 outside the map.
Image nearestTo(const Image& labels, const ImageLattice& on);

}  // namespace slicemorph
