#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"

namespace slicemorph {

/// A function of about the right sign and size to start from, at every node of a lattice in the world: the planes'
/// signed distances, weighted by how near the planes are, and closed beyond the last ones. World units.
std::vector<float> firstGuess(const PlaneSet& planes, const Lattice& lattice);

}  // namespace slicemorph
