#pragma once

#include "engine/match/displacements.h"

namespace slicemorph {

/// Smallest volume of a lattice tetrahedron on any object, over its volume in the middle space.
double leastRatio(const Displacements& map);

/// Smooths the displacements where the map to some object, or to a blend of objects, would squeeze a
/// tetrahedron below `floor` of its volume, until none is left: piecewise linear maps without a fold are then
/// one to one. Returns how many rounds were needed.
int removeFolds(Displacements& map, double floor = 0.12);

}  // namespace slicemorph
