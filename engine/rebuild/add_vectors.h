#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// to += factor * from, at the active voxels of `to`. `from` is a vec3s or vec3d grid on any transform; it is
/// sampled trilinearly at the voxels' world positions, staggered grids on their faces. Throws InputError for
/// grids of other types.
void addVectors(openvdb::Vec3SGrid& to, const openvdb::GridBase& from, double factor);

}  // namespace slicemorph
