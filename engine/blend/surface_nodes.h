#pragma once

#include "engine/blend/lattice_pose.h"
#include "engine/blend/node_map.h"

namespace slicemorph {

/// The nodes near an in-between's surface, with their positions on every object. `transform`: index space of
/// the frame. `step`: voxels between nodes.
NodeMap surfaceNodes(const LatticeOnObjects& on, const LatticePose& pose,
                     const openvdb::math::Transform& transform, int step);

/// Per object, the largest distance between the positions of neighbouring nodes, world units; positions
/// further apart lie on crossing slices of a bent chart. Empty for a straight chart.
std::vector<double> longestJumps(const LatticeOnObjects& on, const Chart& chart,
                                 const openvdb::math::Transform& transform, int step);

}  // namespace slicemorph
