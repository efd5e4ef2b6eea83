#pragma once

#include "slicemorph/conventions.h"

#include <vector>

namespace slicemorph {

/// What of a grid lies so far from the rest that it would hide it: with one voxel of a splash or of noise three hundred
/// lengths away, the body itself would be smaller than a voxel of whatever is laid over both.
struct Strays {
  openvdb::CoordBBox body;             ///< active voxels of all that is no stray
  std::vector<openvdb::Coord> leaves;  ///< origins of the strays' leaves; empty: there are none
  size_t pieces = 0;
  double share = 0;  ///< of the active voxels
};

/// Parts are leaves that touch each other. `grid`: any; active tiles are no strays.
Strays findStrays(const FloatGrid& grid);

/// A level set without those leaves.
FloatGrid::Ptr withoutStrays(const FloatGrid& levelSet, const Strays& strays);

}  // namespace slicemorph
