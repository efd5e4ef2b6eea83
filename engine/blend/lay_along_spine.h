#pragma once

#include "engine/blend/lattice_pose.h"

namespace slicemorph {

/// Gives each part the size it has on its objects where weights differ from node to node: the thickness is
/// scaled per node, the length per slab across the spine, so that slices stay in order. Sets `chart` to one
/// chart for all parts, blended by the mean weights. `pose`: blended by `local`, without chart.
LatticePose layAlongSpine(const std::vector<Chart>& charts, const NodeWeights& local, LatticePose pose);

}  // namespace slicemorph
