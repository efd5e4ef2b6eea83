#pragma once

#include "engine/match/match_objects.h"

namespace slicemorph {

/// Soft intersection over union, 0 to 1, of the objects warped into the middle space; of more than two
/// objects, the sum of all pairs' intersections over the sum of their unions.
double mapOverlap(const MatchObjects& objects, const Displacements& map);

/// How much a map deforms the objects, independent of their size: root mean square of the displacements'
/// derivatives inside them.
double mapStrain(const MatchObjects& objects, const Displacements& map);

}  // namespace slicemorph
