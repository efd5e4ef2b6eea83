#pragma once

#include "engine/match/displacements.h"

namespace slicemorph {

/// Scattered data to which fields are fitted.
struct Sites {
  std::vector<Vec3d> position;            ///< middle space
  std::vector<float> weight;              ///< >= 0
  std::vector<std::vector<Vec3d>> value;  ///< per object, per site
};

/// Fields D, one per object, that minimise sum_i w_i |D(s_i) - v_i|^2 + stiffness * sum_nodes |laplacian D|^2
/// and are zero beyond the lattice: thin-plate smoothing on a lattice, solved by conjugate gradients ([HS52])
/// from `start`, which must be on the same lattice, to a residual of a thousandth or in so many `steps`.
Displacements fitFields(const Lattice& lattice, const Sites& sites, double stiffness,
                        const Displacements& start, int steps = 80);

}  // namespace slicemorph
