#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// A level set's narrow band sampled (trilinearly) at the voxels of another uniform transform, with the
/// inside filled. Distances in world units are kept; they are not recomputed. The band is at most as wide as
/// the level set's own.
FloatGrid::Ptr sampleOnto(const FloatGrid& levelSet, const openvdb::math::Transform& transform);

}  // namespace slicemorph
