#pragma once

#include "engine/blend/moving_lattice.h"

namespace slicemorph {

/// How much the map from an object to an in-between stretches the object's surface beyond the change of size: at each of
/// some samples the longer of the two principal stretches or the inverse of the shorter one, whichever is more; weighted
/// by area.
struct SurfaceStretch {
  double mean = 1, worst = 1;
  double beyond = 0;  ///< share of the area where it is more than kMuch
  double turned = 0;  ///< mean angle, radians, by which it is turned against the surface's own mean rotation

  static constexpr double kMuch = 3;
};

SurfaceStretch surfaceStretch(const MovingLattice& lattice, const DistanceField& field, size_t object,
                              const LatticePose& pose);

}  // namespace slicemorph
