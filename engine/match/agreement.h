#pragma once

#include "engine/frame/align.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// Overlap of the objects in chart space and, after a quick, coarse matching, in the middle space; and how
/// much that bends the objects, free of size.
struct Agreement {
  double before = 0, after = 0;
  double strain = 0;  ///< see mapStrain
};

/// How well objects can be matched at all when their frames are these. Takes slices at equal positions, and
/// follows neither limbs nor lines. `options`: of these objects; its slices and features count.
Agreement quickAgreement(const Fields& fields, const Frames& frames, const MorphOptions& options);

}  // namespace slicemorph
