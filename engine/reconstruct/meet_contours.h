#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Moves the points of a mesh that passes near the contours so that it passes through them to about a quarter
/// of `voxelSize`: meshing a lattice cuts corners by up to 0.6 voxels. The triangles stay the same. Contour
/// points farther off than one voxel are left alone.
void meetContours(const ContourSet& set, double voxelSize, Mesh& mesh);

}  // namespace slicemorph
