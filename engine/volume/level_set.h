#pragma once

#include "slicemorph/mesh.h"
#include "slicemorph/note.h"

#include <string>

namespace slicemorph {

struct LevelSetInput {
  FloatGrid::Ptr grid;
  Notes notes;       ///< what had to be changed, one sentence each
  bool fog = false;  ///< it was a fog volume
};

/// How toLevelSet reads a grid.
struct LevelSetReading {
  float minimum = 0, maximum = 0;  ///< over the active values; 0 where there are none
  double iso = 0;                  ///< the surface's value
  bool fog = false;                ///< of class fog volume, or of no class and without negative values
  std::string rebuilt;  ///< why it has to be rebuilt, as a part of a sentence; empty: it is taken as it is
  std::string problem;  ///< why it is no shape, as a part of a sentence; empty: it is one
};
LevelSetReading readingOf(const FloatGrid& grid, double voxelSize = 0.0, double iso = 0.0);

/// The surface of a grid as it is read, world space, wound outwards.
Mesh surfaceAsRead(const FloatGrid& grid, const LevelSetReading& reading);

/// Turns a grid as found in the wild (dense, in voxel units, rotated or non-uniform transform, other band
/// width) into a level set by the conventions. A grid that already is one is returned as it is, shared, not
/// copied. A fog volume is inside where it is above `iso`; 0 stands there for the value above which three
/// quarters of the total lie, or half the largest value where that is less. `voxelSize`: world units, 0 keeps
/// the grid's own (its smallest where they differ). Throws GeometryError where the grid is empty or has no
/// surface at `iso`.
LevelSetInput toLevelSet(const FloatGrid::ConstPtr& grid, double voxelSize = 0.0, double iso = 0.0);

}  // namespace slicemorph
