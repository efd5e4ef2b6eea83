#pragma once

#include "engine/numerics/lattice_cell.h"

namespace slicemorph {

/// "The function has this value here", as strongly as `weight` says against the bending of a node's
/// surroundings.
struct PlateDatum {
  CellPoint point;
  float target = 0, weight = 1;
};

struct PlateSettings {
  int iterations = 60;
  double tolerance = 1e-3;  ///< of the residual, against the first one
};

/// Minimises the bending energy (sum of all squared second differences) plus the data's squared residuals
/// over the `active` nodes (ascending; none within two nodes of the lattice's border), all others held: conjugate
/// gradients with the diagonal as preconditioner. `values` is the first guess. Returns the steps taken.
int solvePlate(const Lattice& lattice, const std::vector<std::uint32_t>& active,
               const std::vector<PlateDatum>& data, const PlateSettings& settings,
               std::vector<float>& values);

}  // namespace slicemorph
