#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Removes closed shells with a volume below one voxel: bubbles and drops of a single node that redistancing
/// leaves next to the surface. Kept are those near contour points to which nothing else is close.
Mesh withoutSpecks(const Mesh& mesh, const ContourSet& set, double voxelSize);

}  // namespace slicemorph
