#pragma once

#include "engine/rebuild/warp_grid.h"

namespace slicemorph {

/// Colours of one object's surface.
struct CarriedColors {
  openvdb::Vec3SGrid::ConstPtr grid;  ///< on voxels around it, any transform
  const DistanceField* field;         ///< the object
  size_t shape = 0;                   ///< which object of the node map they ride with
  double weight = 0;
  size_t object = 0;  ///< whose weight it is where weights vary
};

/// Colours on the active voxels of an in-between's level set, blended by the weights of the objects that have
/// some there. What the map leads to off an object's coloured voxels takes the colour of the surface nearest
/// to it.
openvdb::Vec3SGrid::Ptr warpColors(const FloatGrid& surface, const std::vector<CarriedColors>& colors,
                                   const NodeMap& nodes, const LocalWeights& weights);

}  // namespace slicemorph
