#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"
#include "engine/match/rounds.h"

namespace slicemorph {

/// The matching after one more round: finds correspondences from every object's samples to the others, fits a
/// smooth map to them, and takes it as far as it improves the overlap. After a soft match that would have cost much
/// overlap the next ones, which are hardly narrower, are left out.
Matching refined(const MatchObjects& objects, Matching matching, const Round& round);

/// The matching after the few kQuickRounds, an estimate of how good it may become.
Matching triedQuickly(const MatchObjects& objects, Matching matching);

}  // namespace slicemorph
