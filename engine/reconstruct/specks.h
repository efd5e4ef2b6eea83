#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Without the closed shells that enclose less than a voxel, bubbles and drops of a single node that distances made
/// anew leave next to the surface, where the rest comes as near to every contour.
Mesh withoutSpecks(const Mesh& mesh, const ContourSet& set, double voxelSize);

}  // namespace slicemorph
