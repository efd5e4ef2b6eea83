#pragma once

#include "slicemorph/voxelise.h"

namespace slicemorph {

/// The index of the triangle nearest to each voxel that is less than `halfWidth` voxels from one, whichever
/// side it is on (or of one that is hardly further away: see MeshToVolume.h); below 0 elsewhere. `mesh`: in
/// the index space of `transform`, open or closed.
openvdb::Int32Grid::Ptr nearestTriangles(const Mesh& mesh, const openvdb::math::Transform& transform,
                                         double halfWidth);

}  // namespace slicemorph
