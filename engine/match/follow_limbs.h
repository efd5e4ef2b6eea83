#pragma once

#include "engine/match/flow.h"
#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// Surface points away from all limbs, in the middle space: the body, which does not move with them. `limbs`:
/// per object.
std::vector<Vec3d> stillPoints(const MatchObjects& objects, const Matching& matching,
                               const std::vector<std::vector<PlacedLimb>>& limbs);

/// The matching with a map that carries limbs onto the correspondences `points`, however far they swing;
/// later rounds hold them there. `still`: middle points that stay fixed.
Matching followLimbs(const MatchObjects& objects, Matching matching, std::vector<Correspondence> points,
                     const std::vector<Vec3d>& still);

/// The same for points all over the bodies, which a finer map can hold. `ways`: see flowed.
Matching followBody(const MatchObjects& objects, Matching matching, std::vector<Correspondence> points,
                    const Ways& ways);

}  // namespace slicemorph
