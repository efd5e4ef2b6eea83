#pragma once

#include "engine/match/middle_samples.h"

namespace slicemorph {

/// Correspondences from every object's samples to where a soft match of all pairs of objects sends them; of
/// more than two objects each target counts as far as it is trusted against the sample's best. `blur`: see
/// softMatch, chart units.
std::vector<Correspondence> softPoints(const Displacements& map, const std::vector<MiddleSamples>& samples,
                                       double blur);

}  // namespace slicemorph
