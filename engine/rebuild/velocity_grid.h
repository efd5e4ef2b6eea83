#pragma once

#include "engine/blend/node_map.h"
#include "slicemorph/slicemorph.h"

#include <functional>
#include <vector>

namespace slicemorph {

/// Upper limit, in voxels, of how far around active voxels velocities are kept. It bounds the cost where they are very
/// high.
constexpr int kMostReach = 24;

using NodeVelocities = std::function<NodeMap(const NodeMap& nodes, const std::vector<char>& wanted)>;

/// The active voxels of a grid, tiles as voxels. Throws InputError for types that are not supported.
openvdb::MaskTree::Ptr activeVoxels(const openvdb::GridBase& where);

/// The grid of velocities that covers a body and what it sweeps: where `body` is active, and as far along its
/// velocities, both ways, as `options.reach` says, so that a trilinear look-up there sees active voxels and rests on
/// nothing else. What does not move is left out: it has the background's value, 0. The voxels are `transform`'s, or as
/// coarse as options.tolerance allows: 2 or 4 times as large, with every second or fourth voxel's centre.
/// `velocities` gives those of a map's nodes that are marked, world units per unit of time; the map's nodes are `step`
/// voxels apart.
openvdb::Vec3SGrid::Ptr velocityGrid(int step, const NodeVelocities& velocities,
                                     const openvdb::MaskTree& body, const openvdb::math::Transform& transform,
                                     const VelocityOptions& options);

}  // namespace slicemorph
