#pragma once

#include "engine/rebuild/warp_grid.h"

namespace slicemorph {

/// Colours of one object's surface, to be carried to an in-between.
struct CarriedColors {
  openvdb::Vec3SGrid::ConstPtr grid;  ///< on voxels around the surface, any transform
  const DistanceField* field;         ///< distance field of the object
  size_t shape = 0;                   ///< index of the object in the node map
  double weight = 0;
  size_t object = 0;  ///< index of the object's weight where weights vary
};

/// Colours at the active voxels of an in-between's level set, blended by the weights of those objects that
/// have colours there. A position outside an object's coloured voxels takes the colour of the nearest point
/// of that object's surface.
openvdb::Vec3SGrid::Ptr warpColors(const FloatGrid& surface, const std::vector<CarriedColors>& colors,
                                   const NodeMap& nodes, const LocalWeights& weights);

}  // namespace slicemorph
