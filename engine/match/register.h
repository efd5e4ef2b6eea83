#pragma once

#include "engine/match/matching.h"
#include "engine/match/rounds.h"
#include "engine/match/slice_objects.h"
#include "slicemorph/progress.h"

#include <optional>

namespace slicemorph {

/// Result of the matching.
struct Registration {
  Displacements map;  ///< free of folds
  Displacements
      base;  ///< to which the rounds added smooth fields: the base warp, or the map that follows limbs
  std::vector<ContourPair> pairs;  ///< accepted pairs of contours
  bool swings = false;             ///< the objects are one body in two poses, whose parts turn
  double overlapBefore = 0;        ///< of the objects in chart space, intersection over union
  double overlapAfter = 0;         ///< of the warped objects in the middle space
  Notes notes;
};

/// Finds a fold-free map between the objects, starting from their contours: base warp of corresponding
/// slices, accepted contour pairs, limbs as wholes, soft matches from coarse to fine, closest points. Each
/// step is kept only as far as the warped objects overlap better than before. `samples`: points along a
/// contour. `rounds`: kWholeRounds or kRoundsBeforeLast. Throws Cancelled.
Registration registerObjects(const MatchObjects& objects, const TracedObjects& traced, int samples,
                             const Rounds& rounds, Progress& progress);

/// Base warp, contour pairs and features only: the start of the matching of more than two objects.
Registration startRegistration(const MatchObjects& objects, const TracedObjects& traced, int samples);

/// Refines a registration made elsewhere by the last rounds of closest points, on all
/// objects. Throws Cancelled.
Registration refineRegistration(Registration made, const MatchObjects& objects, Progress& progress);

/// The registration of a sequence's next frame, from that of the frame before. The charts of `objects` must
/// have been moved along with the objects (trackFrames), so that the map is still nearly right; only fine
/// rounds are run, limbs and contours are not matched again. Returns nothing where the objects overlap
/// clearly less than before, as at a cut in the sequence. Throws Cancelled.
std::optional<Registration> followRegistration(const Registration& before, const MatchObjects& objects,
                                               Progress& progress);

}  // namespace slicemorph
