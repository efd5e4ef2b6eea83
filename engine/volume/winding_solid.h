#pragma once

#include "engine/volume/winding_number.h"

namespace slicemorph {

/// Level set of where the winding number is above 1/2, whatever the mesh: its surface runs along the triangles that
/// part inside from outside, past those that do not, and across holes where the winding number is 1/2. `winding`: of
/// all triangles of `mesh`. `voxelSize`: world units. Only voxels near the triangles and in holes are looked at.
/// Throws InputError as voxelise, GeometryError if nothing is inside.
FloatGrid::Ptr windingLevelSet(const Mesh& mesh, const WindingNumber& winding, double voxelSize);

}  // namespace slicemorph
