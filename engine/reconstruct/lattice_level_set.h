#pragma once

#include "engine/numerics/lattice.h"

namespace slicemorph {

/// The level set of a function on a lattice in the world whose nodes are whole multiples of its spacing, which becomes
/// the voxel size; the function is about a distance near its zero set.
FloatGrid::Ptr latticeLevelSet(const Lattice& lattice, std::vector<float> function);

}  // namespace slicemorph
