#pragma once

#include "engine/frame/align.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// Overlap of the objects in chart space (`before`) and, after a quick, coarse matching, in the middle space
/// (`after`), 0 to 1; and how much that matching deforms the objects.
struct Agreement {
  double before = 0, after = 0;
  double strain = 0;  ///< see mapStrain
};

/// Estimates how well the objects can be matched with these coordinate frames. Uses slices at equal positions
/// and follows neither limbs nor line features. `options`: only `slices`, `samples` and `features` are used.
Agreement quickAgreement(const Fields& fields, const Frames& frames, const MorphOptions& options);

}  // namespace slicemorph
