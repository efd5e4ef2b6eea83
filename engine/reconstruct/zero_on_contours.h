#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"

namespace slicemorph {

/// Takes away what a function on a lattice in the world has left on the planes' contours: each of a few sweeps spreads
/// it over the nodes around.
std::vector<float> zeroOnContours(const PlaneSet& planes, const Lattice& lattice, std::vector<float> values);

}  // namespace slicemorph
