#pragma once

#include "engine/numerics/lattice_cell.h"

namespace slicemorph {

/// "The function equals `target` here." `weight` is relative to the bending of the node's surroundings.
struct PlateDatum {
  CellPoint point;
  float target = 0, weight = 1;
};

struct PlateSettings {
  int iterations = 60;
  double tolerance = 1e-3;  ///< of the residual, relative to the initial one
};

/// Minimises the bending energy (sum of all squared second differences) plus the weighted squared residuals
/// of the data, over the `active` nodes (ascending; none within two nodes of the lattice's border) with all
/// others fixed. Conjugate gradients [HS52] with a diagonal preconditioner. `values` holds the initial guess
/// and receives the result. Returns the number of iterations.
int solvePlate(const Lattice& lattice, const std::vector<std::uint32_t>& active,
               const std::vector<PlateDatum>& data, const PlateSettings& settings,
               std::vector<float>& values);

}  // namespace slicemorph
