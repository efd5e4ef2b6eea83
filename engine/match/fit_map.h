#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// How a map is fitted.
struct MapFit {
  double spacing = 0;    ///< of the lattice, as a fraction of MatchObjects::size
  double stiffness = 0;  ///< see fitFields
};

/// The fold-free map fitted to the correspondences and the user's marks: the matching's base
/// plus smooth fields.
Displacements fittedMap(const MatchObjects& objects, const Matching& matching,
                        std::vector<Correspondence> points, const MapFit& fit);

}  // namespace slicemorph
