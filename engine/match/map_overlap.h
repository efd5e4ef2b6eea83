#pragma once

#include "engine/match/match_objects.h"

namespace slicemorph {

/// Soft intersection over union, 0 to 1, of the objects warped by a map into the middle space; of all their
/// pairs where they are more than two.
double mapOverlap(const MatchObjects& objects, const Displacements& map);

/// How much a map bends the objects, free of size: root mean square of its displacements' derivatives inside
/// them.
double mapStrain(const MatchObjects& objects, const Displacements& map);

}  // namespace slicemorph
