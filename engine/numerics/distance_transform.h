#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Exact distances on a box of voxels with axes at right angles [FH12]: for every
/// voxel the distance between its centre and that of the nearest one of the other kind, positive where
/// `inside`. `spacing`: world units along i (fastest), j, k. Beyond the box all is outside; `inside` must not
/// be empty.
std::vector<float> signedDistances(const std::vector<char>& inside, const openvdb::Coord& size,
                                   const Vec3d& spacing);

}  // namespace slicemorph
