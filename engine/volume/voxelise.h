#pragma once

#include "slicemorph/voxelise.h"

namespace slicemorph {

/// For each voxel less than `halfWidth` voxels from the mesh, on either side, the index of its nearest
/// triangle (or of one hardly further away: see OpenVDB's MeshToVolume.h); below 0 elsewhere. `mesh`: in the
/// index space of `transform`, open or closed.
openvdb::Int32Grid::Ptr nearestTriangles(const Mesh& mesh, const openvdb::math::Transform& transform,
                                         double halfWidth);

}  // namespace slicemorph
