#pragma once

#include "slicemorph/mesh.h"

/// Triangle meshes to level sets and back.
namespace slicemorph {

/// Level set of a closed mesh. `voxelSize`: world units. The sign comes from a flood fill from outside, so
/// the winding does not matter. Throws InputError if the voxel size is not positive or the grid would be
/// absurdly large, GeometryError if the mesh has no faces or nothing is inside.
FloatGrid::Ptr voxelise(const Mesh& mesh, double voxelSize);

/// The triangles of a grid's surface at `iso`, in world space: closed, manifold, wound outwards.
Mesh surfaceOf(const FloatGrid& grid, double iso = 0.0);

}  // namespace slicemorph
