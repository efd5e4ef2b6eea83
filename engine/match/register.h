#pragma once

#include "engine/match/matching.h"
#include "engine/match/rounds.h"
#include "engine/match/slice_objects.h"
#include "slicemorph/progress.h"

#include <optional>

namespace slicemorph {

/// All that the matching found: the map between the objects.
struct Registration {
  Displacements map;  ///< free of folds
  Displacements
      base;  ///< what the matching's smooth fields were added to: slices or limbs laid on each other
  std::vector<ContourPair> pairs;  ///< of contours, that were trusted
  double overlapBefore = 0;        ///< of the objects in chart space, intersection over union
  double overlapAfter = 0;         ///< of the warped objects in the middle space
  Notes notes;
};

/// Matches the objects' contours, and grows from the trusted pairs a fold-free map between the objects: like
/// slices along the spine, base warp, accepted contour pairs, limbs as wholes, soft matches from coarse to
/// fine, closest points. Each is kept only where the warped objects overlap better than before. `samples`:
/// points along a contour. `rounds`: kWholeRounds, or kRoundsBeforeLast.
Registration registerObjects(const MatchObjects& objects, const TracedObjects& traced, int samples,
                             const Rounds& rounds, Progress& progress);

/// Slices, base warp, contour pairs and features alone: what more than two objects start from.
Registration startRegistration(const MatchObjects& objects, const TracedObjects& traced, int samples);

/// A registration whose map was made elsewhere, after the last rounds of closest points on all objects.
Registration refineRegistration(Registration made, const MatchObjects& objects, Progress& progress);

/// The registration of the next frame of a sequence, from the one of the frame before: the charts of `objects`
/// are those moved along with them (`trackFrames`), so that the map still nearly holds. Only fine rounds are
/// run, on top of it; limbs and contours are not matched again. Nothing where the objects so mapped overlap
/// clearly less than before: a cut.
std::optional<Registration> followRegistration(const Registration& before, const MatchObjects& objects,
                                               Progress& progress);

}  // namespace slicemorph
