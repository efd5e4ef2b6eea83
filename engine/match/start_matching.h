#pragma once

#include "engine/match/matching.h"
#include "engine/match/slice_objects.h"

namespace slicemorph {

/// What slices, contours and the user's features make of the objects before any of their parts are matched.
struct MatchingStart {
  Matching matching;
  std::vector<ContourPair> pairs;  ///< that are trusted
  double overlapBefore = 0;        ///< of the objects in chart space, as their frames lay them
};

/// Slices laid on each other, then accepted contour pairs, each as far as the objects overlap better; and the
/// user's features, which are met whatever that does to the overlap. `samples`: points along a contour.
/// `traced`: of the objects.
MatchingStart startMatching(const MatchObjects& objects, const TracedObjects& traced, int samples);

}  // namespace slicemorph
