#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

#include <optional>

namespace slicemorph {

/// The matching of two objects, one of which can be bent onto the other nearly rigidly, as one body in two poses
/// can: limbs are followed whole however far they swing, and points keep their place along them. Nothing where
/// that is not so. The same whichever of the two is named first.
std::optional<Matching> elasticMatching(const MatchObjects& objects, const Matching& matching);

}  // namespace slicemorph
