#pragma once

#include "engine/blend/lattice_pose.h"
#include "engine/blend/node_map.h"

namespace slicemorph {

/// The nodes near an in-between's surface, with their positions on every object. `transform`: index space of the
/// frame; `step`: voxels from node to node. Parallel; the same for any thread count.
NodeMap surfaceNodes(const LatticeOnObjects& on, const LatticePose& pose,
                     const openvdb::math::Transform& transform, int step);

/// Per object, how far apart the positions of neighbouring nodes are at most, world units: further apart they lie on
/// crossing slices of a bent chart. Empty for a straight one.
std::vector<double> longestJumps(const LatticeOnObjects& on, const Chart& chart,
                                 const openvdb::math::Transform& transform, int step);

}  // namespace slicemorph
