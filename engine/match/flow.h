#pragma once

#include "engine/match/contour_pairs.h"

namespace slicemorph {

/// Per object, the positions of all points, in the middle space, at which they are to be one after the other on the way
/// from their middle points to that object.
using Ways = std::vector<std::vector<std::vector<Vec3d>>>;

/// Composes a map with small fold-free steps until it meets the correspondences, however far away they are:
/// limbs can swing past each other where a single fitted displacement would have to fold. `still`: middle
/// points that stay fixed. `spacing`: of the lattice on which each step is fitted, chart units. `lattice`: of
/// the result. `ways`: empty where points go straight.
Displacements flowed(const Displacements& map, const std::vector<Correspondence>& points,
                     const std::vector<Vec3d>& still, double spacing, const Lattice& lattice,
                     const Ways& ways = {});

}  // namespace slicemorph
