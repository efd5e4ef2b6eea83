#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Whether two grids have the same transform, topology and values.
bool isSame(const FloatGrid& a, const FloatGrid& b);

/// Index of the grid in `grids` that is the same, after appending `grid` if there is none:
/// objects that are equal are one shape, whose weights add.
size_t indexOfSame(std::vector<FloatGrid::ConstPtr>& grids, const FloatGrid::ConstPtr& grid);

/// A level set on another voxel size: a copy of the very same values where it is the grid's own, else
/// resampled once. Named `surface`.
FloatGrid::Ptr resampledTo(const FloatGrid::ConstPtr& levelSet, double voxelSize);

}  // namespace slicemorph
