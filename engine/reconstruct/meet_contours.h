#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Moves the points of a mesh that passes near the contours so that it passes within a quarter of `voxelSize`
/// of the contour points; meshing a lattice cuts corners by up to 0.6 voxels. The triangles do not change.
/// Contour points more than one voxel away are ignored.
void meetContours(const ContourSet& set, double voxelSize, Mesh& mesh);

}  // namespace slicemorph
