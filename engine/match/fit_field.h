#pragma once

#include "engine/match/displacements.h"

namespace slicemorph {

/// Scattered values to be met by a field.
struct Sites {
  std::vector<Vec3d> position;            ///< middle space
  std::vector<float> weight;              ///< >= 0
  std::vector<std::vector<Vec3d>> value;  ///< per object, per site
};

/// Least-squares fields, one per object: sum_i w_i |D(s_i) - v_i|^2 + stiffness * sum_nodes |laplacian D|^2,
/// zero beyond the lattice (thin-plate smoothing on a lattice, solved by conjugate gradients from `start`).
Displacements fitFields(const Lattice& lattice, const Sites& sites, double stiffness,
                        const Displacements& start);

}  // namespace slicemorph
