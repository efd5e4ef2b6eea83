#pragma once

#include "engine/match/middle_samples.h"

namespace slicemorph {

/// Correspondences from every object's samples to their targets on the other objects, by soft matches of all
/// pairs of objects in the middle space. Of more than two objects, each target counts in proportion to its
/// trust, relative to the sample's most trusted one. `blur`: see softMatch, chart units.
std::vector<Correspondence> softPoints(const Displacements& map, const std::vector<MiddleSamples>& samples,
                                       double blur);

}  // namespace slicemorph
