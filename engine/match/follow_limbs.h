#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// Surface points well away from all limbs, middle space: the body, which does not swing with them. `limbs`:
/// per object.
std::vector<Vec3d> stillPoints(const MatchObjects& objects, const Matching& matching,
                               const std::vector<std::vector<PlacedLimb>>& limbs);

/// The matching with a map that leads limbs to where `points` say, however far they swing, and keeps them
/// there from then on. `still`: middle points that keep their positions.
Matching followLimbs(const MatchObjects& objects, Matching matching, std::vector<Correspondence> points,
                     const std::vector<Vec3d>& still);

}  // namespace slicemorph
