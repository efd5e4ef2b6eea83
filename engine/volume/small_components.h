#pragma once

#include "slicemorph/conventions.h"

#include <vector>

namespace slicemorph {

/// Number of connected components (6-neighbours) of the level set's inside, at least 1. Components below 27
/// voxels and below 0.1 % of the inside voxels in leaves are not counted: thin tips leave such fragments.
int countPieces(const FloatGrid& levelSet);

/// A connected component of the inside that is not among the largest.
struct LooseComponent {
  std::vector<openvdb::Coord> voxels;  ///< inside
  double share = 0;                    ///< of the inside voxels in leaves
};

/// All but the `allowed` largest components, those with inside tiles counted as one, the smallest first; never one with inside tiles.
std::vector<LooseComponent> looseComponents(const FloatGrid& levelSet, int allowed);

/// Removes those of the level set's loose components that hold less than 3 % of the inside voxels in leaves. Such
/// components break off where a feature gets thinner than a voxel or two. Returns the number removed.
int removeSmallComponents(FloatGrid& levelSet, const std::vector<LooseComponent>& loose);

/// Fills voids of a single voxel, outside between six inside neighbours: below what a grid can hold, and a shell of its own in a
/// mesh. Returns their number.
int fillVoxelVoids(FloatGrid& levelSet);

}  // namespace slicemorph
