#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Connected parts (over faces) of a level set's inside, but for dust of a few voxels.
int countPieces(const FloatGrid& levelSet);

/// Removes the smallest parts of the inside while there are more than `allowed`, but only crumbs: parts of
/// less than 3 % of the inside voxels next to the surface, as tear off where a feature is thinner than a
/// voxel or two. Returns how many were removed.
int removeSmallComponents(FloatGrid& levelSet, int allowed);

}  // namespace slicemorph
