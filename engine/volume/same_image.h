#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// Whether two lattices have as many voxels at the same places, to this part of a voxel: positions in files are rounded.
bool sameLattice(const ImageLattice& a, const ImageLattice& b, double tolerance = 1e-4);

/// Whether two images have the same values on the same lattice, whatever their number types. What is not a number
/// equals its like.
bool isSame(const Image& a, const Image& b);

}  // namespace slicemorph
