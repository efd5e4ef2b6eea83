#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// A grid of one object, to be carried by the map of its shape.
struct CarriedGrid {
  openvdb::GridBase::ConstPtr grid;  ///< of a type that canCarry() accepts, any transform
  size_t shape = 0;                  ///< index of the object in the node map
  Vec3d anchor{0, 0, 0};             ///< anchor of that object's distance field, world
  double weight = 0;
  size_t object = 0;  ///< index of the object's weight where weights vary
};

/// Whether grids of this type can be carried. Values of float, double, vec3s and vec3d grids are blended; for
/// bool, mask, int32, int64 and vec3i the nearest voxel of a single object is taken.
bool canCarry(const openvdb::GridBase& grid);
bool isBlended(const openvdb::GridBase& grid);

/// The first grid's transform if all grids have its axes and voxel size, else the world's axes with the
/// weighted mean of the voxel sizes.
openvdb::math::Transform::Ptr commonTransform(const std::vector<CarriedGrid>& grids);

/// The map of an in-between.
struct Carrying {
  const MovingLattice* lattice = nullptr;           ///< null: one object that does not move
  std::shared_ptr<const MovingLattice::Pose> pose;  ///< of the lattice
  Vec3d anchor{0, 0, 0};                            ///< without a lattice: the object's anchor, world
};

/// Index-space box of the in-between that holds the carried active voxels of all grids.
openvdb::CoordBBox boxOf(const std::vector<CarriedGrid>& grids, const Carrying& carrying,
                         const openvdb::math::Transform& transform);

/// Voxels between map nodes for this index-space box: 4 or 8.
int carryingStep(const openvdb::CoordBBox& box);

/// Map nodes over a box of the in-between's index space, `step` voxels apart.
NodeMap carryingNodes(const openvdb::CoordBBox& box, const Carrying& carrying,
                      const openvdb::math::Transform& transform, int step);

/// In-between of the grids: sum_k w_k g_k(M_k(p)), leaf by leaf and only where some grid is active, with the
/// type and class of the first grid. Values are splined, those of level sets trilinear. Where the weights sum
/// to less than 1 the first grid's background fills the rest. Vectors turn with the map's rotation unless
/// they are colours or texture coordinates; staggered components are sampled on their faces. Colours
/// (recognised by name) are averaged over the active voxels only.
/// `weights`: of the objects, everywhere or by region. `conserve`: scalar values are densities, divided by
/// the map's change of volume, so that the total is the weighted sum of the inputs' totals. Throws InputError
/// for grids of different types, and for more than one grid of a type that is not blended.
openvdb::GridBase::Ptr warpGrids(const std::vector<CarriedGrid>& grids, const NodeMap& nodes,
                                 const LocalWeights& weights, const openvdb::math::Transform& transform,
                                 bool conserve);

}  // namespace slicemorph
