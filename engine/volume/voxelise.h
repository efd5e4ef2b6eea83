#pragma once

#include "slicemorph/voxelise.h"

namespace slicemorph {

/// Distance to a mesh, open or closed, within `halfWidth` voxels of it on either side: never negative. `voxelSize`:
/// world units. Throws as voxelise for an absurd size.
FloatGrid::Ptr unsignedDistance(const Mesh& mesh, double voxelSize, double halfWidth = kHalfWidth);

/// Throws GeometryError where no voxel of a level set is inside.
void requireInside(const FloatGrid& grid);

/// Voxels of the narrow band around a surface, about. A band of kMostBandVoxels takes about 3 GiB, and more while it is
/// built; for more than that voxelise refuses the voxel size, whatever memory there is.
double bandVoxelsOf(double area, double voxelSize);
constexpr double kMostBandVoxels = 4e8;

/// For each voxel less than `halfWidth` voxels from the mesh, on either side, the index of its nearest
/// triangle (or of one hardly further away: see OpenVDB's MeshToVolume.h); below 0 elsewhere. `mesh`: in the
/// index space of `transform`, open or closed.
openvdb::Int32Grid::Ptr nearestTriangles(const Mesh& mesh, const openvdb::math::Transform& transform,
                                         double halfWidth);

}  // namespace slicemorph
