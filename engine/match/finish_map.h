#pragma once

#include "engine/match/match_objects.h"

namespace slicemorph {

/// The map on the finer lattice from which in-betweens are made, again free of folds.
Displacements finishedMap(const MatchObjects& objects, const Displacements& map);

/// The displacements on a lattice that covers the objects' present boxes and whose nodes coincide with those
/// of `before`. Nodes keep their values, so that repeating this from frame to frame blurs nothing; new nodes
/// take the value of the nearest outermost one.
Displacements continuedOver(const MatchObjects& objects, const Displacements& before);

}  // namespace slicemorph
