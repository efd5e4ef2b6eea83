#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Share of a mesh's area, 0 to 1, that bounds nothing in the mesh's own level set: neither half a voxel before nor half
/// a voxel behind it is inside. Such walls are thinner than a voxel and fall between the voxels. Measured at about
/// 20,000 points spread evenly; 0 for no area.
double lostShare(const Mesh& mesh, const FloatGrid& levelSet);

}  // namespace slicemorph
