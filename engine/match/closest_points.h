#pragma once

#include "engine/frame/align.h"
#include "engine/match/middle_samples.h"

namespace slicemorph {

/// Correspondences from every object's samples to the closest surface points of the others, as far as these
/// are near and face the same way. `fields`: per object, null where one has no such surface. `reach`: how far
/// off a closest point may lie, chart units.
std::vector<Correspondence> closestPoints(const Fields& fields, const std::vector<Chart>& charts,
                                          const Displacements& map, const std::vector<MiddleSamples>& samples,
                                          double reach);

}  // namespace slicemorph
