#pragma once

#include "slicemorph/conventions.h"

/// Level sets by fast sweeping ([Zha05], OpenVDB's implementation), trimmed to a band of `band` world units
/// on either side of the surface.
namespace slicemorph {

/// From any function with the same zero set on its active voxels; it need not be a distance. All
/// values are recomputed.
FloatGrid::Ptr sweptLevelSet(const FloatGrid& field, float band);

/// From a level set whose band is too narrow by up to `voxels`: existing values are kept, those beyond them
/// are swept.
FloatGrid::Ptr widenedLevelSet(const FloatGrid& levelSet, int voxels, float band);

}  // namespace slicemorph
