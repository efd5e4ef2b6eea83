#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Whether two grids have the same transform, background, topology and values.
bool isSame(const FloatGrid& a, const FloatGrid& b);

/// Index of the grid in `grids` that equals `grid`; appends it if there is none. Equal objects share one
/// shape, and their weights add up.
size_t indexOfSame(std::vector<FloatGrid::ConstPtr>& grids, const FloatGrid::ConstPtr& grid);

/// A level set at another voxel size (world units): an exact copy if it is the grid's own, else resampled
/// once. Named `surface`.
FloatGrid::Ptr resampledTo(const FloatGrid::ConstPtr& levelSet, double voxelSize);

}  // namespace slicemorph
