#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"

namespace slicemorph {

/// Initial values, world units, at every node of a lattice in world space: the mean of the planes' signed
/// distances, weighted by how near the planes are, and closed beyond the outermost ones.
std::vector<float> firstGuess(const PlaneSet& planes, const Lattice& lattice);

}  // namespace slicemorph
