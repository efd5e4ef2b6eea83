#pragma once

#include "slicemorph/level_set.h"
#include "slicemorph/mesh.h"

#include <string>

namespace slicemorph {

/// How toLevelSet interprets a grid.
struct LevelSetReading {
  float minimum = 0, maximum = 0;  ///< over the active values; 0 if there are none
  double iso = 0;                  ///< value of the surface
  bool fog = false;  ///< of class fog volume, or of no class, without negative values and with background 0
  std::string rebuilt;  ///< why it has to be rebuilt, as part of a sentence; empty: it is used as it is
  std::string problem;  ///< why it is no shape, as part of a sentence; empty: it is one
};
LevelSetReading readingOf(const FloatGrid& grid, double voxelSize = 0.0, double iso = 0.0);

/// The surface of a grid as interpreted by `reading`: world space, wound outwards.
Mesh surfaceAsRead(const FloatGrid& grid, const LevelSetReading& reading);

}  // namespace slicemorph
