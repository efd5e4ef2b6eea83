#pragma once

#include "engine/match/match_objects.h"

namespace slicemorph {

/// Soft intersection over union, 0 to 1, of the objects warped into the middle space; of more than two
/// objects, the sum of all pairs' intersections over the sum of their unions.
double mapOverlap(const MatchObjects& objects, const Displacements& map);

/// The same around each of some lines in the middle space: at positions up to `reach` from one of its points and nearer to
/// it than to the other lines; 0 where nothing is there.
std::vector<double> overlapsAround(const MatchObjects& objects, const Displacements& map,
                                   const std::vector<std::vector<Vec3d>>& lines, double reach);

/// How much a map deforms the objects, independent of their size: root mean square of the displacements'
/// derivatives inside them.
double mapStrain(const MatchObjects& objects, const Displacements& map);

}  // namespace slicemorph
