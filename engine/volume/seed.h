#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// A ball of two voxels inside a shape, at the deepest voxel of its band that is nearest to the middle of these; from
/// it the shape can grow. `levelSet`: by the conventions, not empty.
FloatGrid::Ptr seedIn(const FloatGrid& levelSet);

}  // namespace slicemorph
