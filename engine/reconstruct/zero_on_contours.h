#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"

namespace slicemorph {

/// Removes what a function on a lattice in world space still differs from zero on the planes' contours: in a
/// few sweeps the differences are distributed to the surrounding nodes.
std::vector<float> zeroOnContours(const PlaneSet& planes, const Lattice& lattice, std::vector<float> values);

}  // namespace slicemorph
