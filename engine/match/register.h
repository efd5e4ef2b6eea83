#pragma once

#include "engine/frame/align.h"
#include "engine/match/contour_pairs.h"
#include "slicemorph/note.h"

#include <optional>

namespace slicemorph {

/// All that the matching found: the map between the objects, and the slices it started from.
struct Registration {
  Displacements map;  ///< free of folds
  Displacements
      base;  ///< what the matching's smooth fields were added to: slices or limbs laid on each other
  SlicePlanes planes;
  std::vector<ContourStack> stacks;
  std::vector<ContourPair> pairs;
  double overlapBefore = 0;  ///< of the objects in chart space, intersection over union
  double overlapAfter = 0;   ///< of the warped objects in the middle space
  Notes notes;
};

/// Slices the objects, traces and matches their contours, and grows from the trusted pairs a fold-free map
/// between them: like slices along the spine, base warp, accepted contour pairs, limbs as wholes, soft
/// matches from coarse to fine, closest points. Each is kept only where the warped objects overlap better
/// than before. `inner`: further surfaces, each per object, null where one has none; they and the features of
/// the options (of these objects) steer the map. `last`: with the last, finest rounds.
Registration registerObjects(const Fields& fields, const std::vector<Fields>& inner, const Frames& frames,
                             const MorphOptions& options, Progress& progress, bool last = true);

/// Slices, base warp, contour pairs and features alone: what more than two objects start from.
Registration startRegistration(const Fields& fields, const Frames& frames, const MorphOptions& options,
                               Progress& progress);

/// A registration whose map was made elsewhere, after the last rounds of closest points on all objects.
Registration refineRegistration(Registration made, const Fields& fields, const std::vector<Fields>& inner,
                                const Frames& frames, const MorphOptions& options, Progress& progress);

/// The registration of the next frame of a sequence, from the one of the frame before: `frames` are those
/// moved along with the objects (`trackFrames`), so that the map still nearly holds. Only fine rounds are
/// run, on top of it; limbs and contours are not matched again. Nothing where the objects so mapped overlap
/// clearly less than before: a cut.
std::optional<Registration> followRegistration(const Registration& before, const Fields& fields,
                                               const std::vector<Fields>& inner, const Frames& frames,
                                               const MorphOptions& options, Progress& progress);

/// Overlap of the objects in chart space and, after a quick, coarse matching, in the middle space; and how
/// much that bends the objects, free of size.
struct Agreement {
  double before = 0, after = 0;
  double strain = 0;  ///< root mean square of the displacements' derivatives inside the objects
};
Agreement quickAgreement(const Fields& fields, const Frames& frames, const MorphOptions& options,
                         Progress& progress);

}  // namespace slicemorph
