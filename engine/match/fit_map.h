#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// How a map is fitted.
struct MapFit {
  double spacing = 0;    ///< of the lattice, in the objects' sizes
  double stiffness = 0;  ///< see fitFields
};

/// The smooth, fold-free map that meets the correspondences and the user's marks: smooth fields on top of
/// the matching's base.
Displacements fittedMap(const MatchObjects& objects, const Matching& matching,
                        std::vector<Correspondence> points, const MapFit& fit);

}  // namespace slicemorph
