#pragma once

#include "engine/frame/align.h"
#include "engine/match/middle_samples.h"

namespace slicemorph {

/// Correspondences from every object's samples to the closest surface points of the other objects, weighted
/// by how near these are and by how well the normals agree; the closest points of ICP ([BM92]). `fields`: per
/// object, null for an object without such a surface. `samples`: per object. `reach`: distance at which a
/// closest point no longer counts, chart units.
std::vector<Correspondence> closestPoints(const Fields& fields, const std::vector<Chart>& charts,
                                          const Displacements& map, const std::vector<MiddleSamples>& samples,
                                          double reach);

}  // namespace slicemorph
