#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Exact signed distances on a box of voxels with orthogonal axes [FH12]: for every voxel the distance from
/// its centre to the nearest centre of the other kind, positive where `inside`. `spacing`: world units along
/// i (fastest in memory), j, k. Voxels beyond the box are ignored; without any voxel of the other
/// kind the distance is 1e10.
std::vector<float> signedDistances(const std::vector<char>& inside, const openvdb::Coord& size,
                                   const Vec3d& spacing);

}  // namespace slicemorph
