#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// Matches limbs as wholes: a leg with the leg that leaves the body at the same position, however far it has
/// swung. Returns the matchings from which the rounds may start: a single one where following limbs clearly
/// wins or cannot win, otherwise all those that may turn out best.
std::vector<Matching> limbCandidates(const MatchObjects& objects, const Matching& matching);

}  // namespace slicemorph
