#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// Correspondences from points deep inside every object's thin parts to the nearest points deep inside the other
/// objects, weighted by how near these are. Where a leg is a few voxels thick, closest surface points bring it near the
/// other's leg but not onto it, and a blend of distances then breaks it. `reach`: distance at which such a point no longer
/// counts, chart units.
std::vector<Correspondence> corePoints(const MatchObjects& objects, const Matching& matching, double reach);

}  // namespace slicemorph
