#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Adds `factor` times the vectors of a vec3s or vec3d grid (on any transform, staggered or not) to those of
/// another at its active voxels. Throws InputError for grids of other types.
void addVectors(openvdb::Vec3SGrid& to, const openvdb::GridBase& from, double factor);

}  // namespace slicemorph
