#pragma once

#include "engine/numerics/lattice.h"

namespace slicemorph {

/// Level set of a function on a lattice in world space that is about a distance near its zero set. The nodes
/// must be at whole multiples of the lattice's spacing, which becomes the voxel size.
FloatGrid::Ptr latticeLevelSet(const Lattice& lattice, std::vector<float> function);

}  // namespace slicemorph
