#pragma once

#include "slicemorph/mesh.h"

namespace slicemorph {

/// Level set of a closed mesh. `voxelSize`: world units. The sign comes from a flood fill from outside, so
/// the winding does not matter. Throws InputError where the voxel size is not positive or the grid would be
/// absurdly large, GeometryError where nothing lies inside.
FloatGrid::Ptr voxelise(const Mesh& mesh, double voxelSize);

/// The index of the triangle nearest to each voxel that is less than `halfWidth` voxels from one, whichever
/// side it is on (or of one that is hardly further away: see MeshToVolume.h); below 0 elsewhere. `mesh`: in
/// the index space of `transform`, open or closed.
openvdb::Int32Grid::Ptr nearestTriangles(const Mesh& mesh, const openvdb::math::Transform& transform,
                                         double halfWidth);

/// The triangles of a grid's surface at `iso` in world space: closed, manifold, wound outwards.
Mesh surfaceOf(const FloatGrid& grid, double iso = 0.0);

}  // namespace slicemorph
