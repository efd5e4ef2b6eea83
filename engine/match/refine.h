#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"
#include "engine/match/rounds.h"

namespace slicemorph {

/// The matching after one round more: points of every object look for their places on the others, a smooth
/// map is fitted to what they find, and is taken as far as the objects overlap better.
Matching refined(const MatchObjects& objects, Matching matching, const Round& round);

/// After a quick matching from there: how good it may become.
Matching triedQuickly(const MatchObjects& objects, Matching matching);

}  // namespace slicemorph
