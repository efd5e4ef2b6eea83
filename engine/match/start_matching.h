#pragma once

#include "engine/match/matching.h"
#include "engine/match/slice_objects.h"

namespace slicemorph {

/// The matching by slices, contours and the user's features, before limbs and surface points are matched.
struct MatchingStart {
  Matching matching;
  std::vector<ContourPair> pairs;  ///< accepted ones
  double overlapBefore = 0;        ///< of the objects in chart space, without any warp
};

/// The base warp, then the accepted contour pairs, each as far as it improves the overlap; then the user's
/// features, whatever they do to the overlap. `traced`: of the objects. `samples`: points along a contour.
MatchingStart startMatching(const MatchObjects& objects, const TracedObjects& traced, int samples);

}  // namespace slicemorph
