#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// Limbs are matched as wholes: a leg meets the leg that leaves the body at the same place, however far it
/// has swung. Returns the matchings from which the rounds may start: one where following limbs wins beyond
/// doubt or cannot win, else all those that may turn out best.
std::vector<Matching> limbCandidates(const MatchObjects& objects, const Matching& matching);

}  // namespace slicemorph
