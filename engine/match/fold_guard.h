#pragma once

#include "engine/match/displacements.h"

namespace slicemorph {

/// Smallest ratio, over all objects and lattice tetrahedra, of a tetrahedron's signed volume on the object to
/// its volume in the middle space.
double leastRatio(const Displacements& map);

/// Smooths the displacements where the map to an object, or to the in-between half way from the middle to it,
/// squeezes a tetrahedron below `floor` times its volume, until none is left. A map that is linear on
/// tetrahedra and has no fold is one to one. Returns the number of rounds.
int removeFolds(Displacements& map, double floor = 0.12);

}  // namespace slicemorph
