#pragma once

#include "engine/frame/align.h"
#include "slicemorph/progress.h"

namespace slicemorph {

/// Chooses how the objects are laid on each other: turned against the first, about straight or curved spines,
/// twisted or not. Each change must win overlap after a quick, coarse matching, less its price; overlap
/// before warping misleads where shapes differ much. `names`: of the objects, for notes. `progress`: may
/// cancel it.
Frames chooseFrames(const Fields& fields, const std::vector<std::string>& names, const MorphOptions& options,
                    const Progress& progress);

}  // namespace slicemorph
