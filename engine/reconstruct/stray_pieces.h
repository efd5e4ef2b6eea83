#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"

namespace slicemorph {

struct WithoutStrays {
  std::vector<float> values;
  int strays = 0;  ///< number of pieces that were removed
};

/// Flips the sign of those connected pieces of a function's inside and outside that no contour touches.
WithoutStrays dropStrayPieces(const PlaneSet& planes, const Lattice& lattice, std::vector<float> values);

}  // namespace slicemorph
