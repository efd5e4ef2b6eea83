#pragma once

#include "engine/blend/moving_lattice.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// The parts of a plan from which in-betweens are made.
struct MorphParts {
  const MovingLattice& lattice;
  const Fields& fields;
  const Frames& frames;
};

/// The map near the surface of an in-between.
struct SurfaceMap {
  std::shared_ptr<const MovingLattice::Pose> pose;
  openvdb::math::Transform::ConstPtr transform;
  NodeMap nodes;
};

/// An in-between, and what its grids have in common with it.
struct RebuiltShape {
  InBetween shape;
  std::shared_ptr<const SurfaceMap> map;  ///< null where the in-between is one of the objects
};

/// The in-between for these weights. `pose` is the lattice's pose at the same weights, `voxelSize` in world
/// units. Its shape is the level set and the folded share of the map; small loose components are still in it.
RebuiltShape rebuildInBetween(const MorphParts& parts, const Weights& weights,
                              std::shared_ptr<const MovingLattice::Pose> pose, double voxelSize);

}  // namespace slicemorph
