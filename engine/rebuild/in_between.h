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

/// The in-between for these weights. `pose` is the lattice's pose at the same weights, `voxelSize` in world
/// units. Returns its level set and the folded share of the map; small loose components are still in it.
InBetween rebuildInBetween(const MorphParts& parts, const Weights& weights, const MovingLattice::Pose& pose,
                           double voxelSize);

}  // namespace slicemorph
