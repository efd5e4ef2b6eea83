#pragma once

#include "engine/match/match_objects.h"

namespace slicemorph {

/// The map on the lattice that frames move: as fine as the eye needs, still free of folds.
Displacements finishedMap(const MatchObjects& objects, const Displacements& map);

/// The displacements on a lattice of the same nodes that covers the objects as they are now. Nodes keep what
/// they have, so that frame after frame blurs nothing; beyond them is what the outermost ones say.
Displacements continuedOver(const MatchObjects& objects, const Displacements& before);

}  // namespace slicemorph
