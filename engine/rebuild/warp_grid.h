#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// One object's values, carried along by the map of its shape.
struct CarriedGrid {
  openvdb::GridBase::ConstPtr grid;  ///< of a type that canCarry, any transform
  size_t shape = 0;                  ///< which object of the node map they ride with
  Vec3d anchor{0, 0, 0};             ///< of that object's field
  double weight = 0;
  size_t object = 0;  ///< whose weight it is where weights vary
};

/// Whether values of the grid's type can be carried. Float, double, vec3s and vec3d are blended; of bool,
/// mask, int32, int64 and vec3i the nearest voxel is taken, of one object alone.
bool canCarry(const openvdb::GridBase& grid);
bool isBlended(const openvdb::GridBase& grid);

/// The first grid's own transform where all have its axes and voxels, else the world's axes with the weighted
/// mean of the voxel sizes.
openvdb::math::Transform::Ptr commonTransform(const std::vector<CarriedGrid>& grids);

/// Where the objects of an in-between are: what carries grids.
struct Carrying {
  const MovingLattice* lattice = nullptr;  ///< null: one object that stays where it is
  MovingLattice::Pose pose;
  Vec3d anchor{0, 0, 0};  ///< without a lattice, of that object
};

/// Box of index space that holds all that the grids have on an in-between.
openvdb::CoordBBox boxOf(const std::vector<CarriedGrid>& grids, const Carrying& carrying,
                         const openvdb::math::Transform& transform);

/// Voxels between the nodes that carry what is in a box of index space.
int carryingStep(const openvdb::CoordBBox& box);

/// The nodes that carry what is in a box of an in-between's index space.
NodeMap carryingNodes(const openvdb::CoordBBox& box, const Carrying& carrying,
                      const openvdb::math::Transform& transform, int step);

/// In-between of the grids: sum_k w_k g_k(M_k(p)), trilinear, leaf by leaf and only where some grid is
/// active; what is missing to a sum of weights of 1 is background. Of the first grid's type and class.
/// Vectors turn with the map's rotation unless they are colours or positions; staggered ones are taken face by
/// face. Colours, by their name, are blended by their weights among what is active, and so is what lies
/// between voxels. `weights`: of the objects at each position. `conserve`: densities, whose total is the
/// weighted sum of theirs, thinned where the map widens. Throws InputError for grids of different types, and
/// for more than one of a type that is not blended.
openvdb::GridBase::Ptr warpGrids(const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
                                 const LocalWeights& weights, const openvdb::math::Transform& transform,
                                 bool conserve);

}  // namespace slicemorph
