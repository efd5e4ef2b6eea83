#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// One object's values, carried along by the map of its shape.
struct CarriedGrid {
  openvdb::GridBase::ConstPtr grid;  ///< float, double, vec3s or vec3d values, any transform
  size_t shape = 0;                  ///< which object of the node map they ride with
  Vec3d anchor{0, 0, 0};             ///< of that object's field
  double weight = 0;
};

/// The grids' own transform if they have one in common, else the world's axes with the weighted mean of their voxel sizes.
openvdb::math::Transform::Ptr commonTransform(const std::vector<CarriedGrid>& grids);

/// The nodes that carry the grids on an in-between's index space; `lattice` null: of objects that stay where they are.
NodeMap nodesOf(const std::vector<CarriedGrid>& grids, const MovingLattice* lattice, const Weights& weights,
                const openvdb::math::Transform& transform);

/// In-between of the grids: sum_k w_k g_k(M_k(p)), trilinear, leaf by leaf and only where some grid is active. All grids
/// are of the first one's type; the result has its background and class. Vectors turn with the map's rotation.
/// `conserve`: densities, whose total is the weighted sum of theirs, thinned where the map widens.
openvdb::GridBase::Ptr warpGrids(const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
                                 const openvdb::math::Transform& transform, bool conserve);

}  // namespace slicemorph
