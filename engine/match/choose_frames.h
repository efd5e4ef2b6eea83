#pragma once

#include "engine/frame/align.h"
#include "slicemorph/progress.h"

namespace slicemorph {

/// Chooses the coordinate frames of the objects: their rotations relative to the first object, straight or
/// curved spines, twist or none. Rotations are chosen by inner distances, and where these do not decide as the rest: a
/// change is accepted only if it gains more overlap than its price. Overlap is measured after a quick, coarse matching
/// too, since overlap before warping misleads where shapes differ much. `names`: of the objects, for notes. Throws Cancelled when `progress` is cancelled.
Frames chooseFrames(const Fields& fields, const std::vector<std::string>& names, const MorphOptions& options,
                    const Progress& progress);

}  // namespace slicemorph
