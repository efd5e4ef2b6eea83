#pragma once

#include "engine/match/displacements.h"
#include "engine/spine/chart.h"

#include <array>

namespace slicemorph {

/// What two densities of one world and the map between them are off each other half way: sum |a - b| / sum |a + b| over
/// the lattice's nodes; 0: they lie on each other.
struct DensityMatch {
  Displacements map;
  double before = 0, after = 0;  ///< of the map that was given, and of `map`
};

/// Of each object: how fast it moves, world units in any unit of time, the same for both; staggered ones too. Null: not
/// known.
using DensityVelocities = std::array<openvdb::Vec3SGrid::ConstPtr, 2>;

/// The map that lays two densities, of two objects, on each other half way: two frames of a simulation. Found anew from
/// coarse to fine by Gauss and Newton's steps [LK81], symmetric in both, on compressed densities, so that thin smoke
/// counts; smooth, nearly without divergence, and only lightly bound to what was found at coarser levels, as smoke
/// swirls. Paths bend as those of a fluid do that is not compressed. Begun from nothing, from the map that is given, and
/// from where the velocities carry it, which finds ways too far for a search; what fits best is taken, the map itself
/// where that does. Where velocities agree with the ways found, paths leave and arrive with them. `chart`: of both
/// objects. Free of folds.
DensityMatch matchDensities(const std::array<FloatGrid::ConstPtr, 2>& densities,
                            const DensityVelocities& velocities, const Chart& chart,
                            const Displacements& map);

}  // namespace slicemorph
