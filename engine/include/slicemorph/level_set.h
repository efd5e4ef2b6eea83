#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// A grid converted to a level set that follows the conventions.
struct LevelSetInput {
  FloatGrid::Ptr grid;
  Notes notes;       ///< what had to be changed, one sentence each
  bool fog = false;  ///< the input was a fog volume
};

/// Converts a grid as found in practice (dense, in voxel units, with a rotated or non-uniform transform,
/// another band width) to a level set that follows the conventions. A grid that already does is returned as
/// it is, shared, not copied. A fog volume is inside where its values exceed `iso`; 0 selects the value above
/// which three quarters of the total lie, or half the largest value if that is less. `voxelSize`: world
/// units; 0 keeps the grid's own (the smallest of the three if they differ). Throws GeometryError if the grid
/// is empty, has values that are not finite, or has no surface at `iso`; InputError if `iso` or `voxelSize`
/// is invalid.
LevelSetInput toLevelSet(const FloatGrid::ConstPtr& grid, double voxelSize = 0.0, double iso = 0.0);

}  // namespace slicemorph
