#pragma once

#include "engine/match/contour_pairs.h"

namespace slicemorph {

/// The map carried on until it meets the correspondences, however far off they are, in small steps none of
/// which folds: limbs swing past each other where one displacement, fitted at once, would have to fold.
/// `still`: middle points that keep their places. `spacing`: of the fields fitted; the result lies on
/// `lattice`.
Displacements flowed(const Displacements& map, const std::vector<Correspondence>& points,
                     const std::vector<Vec3d>& still, double spacing, const Lattice& lattice);

}  // namespace slicemorph
