#pragma once

#include "engine/blend/lattice_pose.h"

namespace slicemorph {

/// Where weights differ from node to node each part keeps the size it has on its objects: thickness node by node,
/// length slice by slice, so that slices never overtake each other. One chart holds them all, turned and placed as the
/// mean. `pose`: blended by `local`, without chart.
LatticePose layAlongSpine(const std::vector<Chart>& charts, const NodeWeights& local, LatticePose pose);

}  // namespace slicemorph
