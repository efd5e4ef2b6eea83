#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// A grid that was made a level set by the conventions.
struct LevelSetInput {
  FloatGrid::Ptr grid;
  Notes notes;       ///< what had to be changed, one sentence each
  bool fog = false;  ///< it was a fog volume
};

/// Turns a grid as found in the wild (dense, in voxel units, rotated or non-uniform transform, other band
/// width) into a level set by the conventions. A grid that already is one is returned as it is, shared, not
/// copied. A fog volume is inside where it is above `iso`; 0 stands there for the value above which three
/// quarters of the total lie, or half the largest value where that is less. `voxelSize`: world units, 0 keeps
/// the grid's own (its smallest where they differ). Throws GeometryError where the grid is empty or has no
/// surface at `iso`.
LevelSetInput toLevelSet(const FloatGrid::ConstPtr& grid, double voxelSize = 0.0, double iso = 0.0);

}  // namespace slicemorph
