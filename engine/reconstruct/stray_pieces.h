#pragma once

#include "engine/numerics/lattice.h"
#include "engine/reconstruct/plane_set.h"

namespace slicemorph {

struct WithoutStrays {
  std::vector<float> values;
  int strays = 0;  ///< pieces that were left out
};

/// Turns the sign of the pieces of a function's inside and outside that no contour touches.
WithoutStrays dropStrayPieces(const PlaneSet& planes, const Lattice& lattice, std::vector<float> values);

}  // namespace slicemorph
