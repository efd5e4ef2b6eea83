#pragma once

#include "engine/blend/moving_lattice.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// What in-betweens are made of.
struct MorphParts {
  const MovingLattice& lattice;
  const Fields& fields;
  const Frames& frames;
};

/// The in-between of these weights, whose pose is `pose`: its level set, with voxels of `voxelSize` world
/// units, and how much of the map folds there. Loose parts are left in it.
InBetween rebuildInBetween(const MorphParts& parts, const Weights& weights, const MovingLattice::Pose& pose,
                           double voxelSize);

}  // namespace slicemorph
