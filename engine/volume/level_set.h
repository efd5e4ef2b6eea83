#pragma once

#include "slicemorph/level_set.h"
#include "slicemorph/mesh.h"

#include <string>

namespace slicemorph {

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

}  // namespace slicemorph
