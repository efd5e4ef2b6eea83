#pragma once

#include "slicemorph/conventions.h"

/// Level sets by fast sweeping ([Zha05], in OpenVDB), trimmed to `band` world units.
namespace slicemorph {

/// Of a function with the same zero set on its active voxels, which need not be a distance: every value is
/// swept anew.
FloatGrid::Ptr sweptLevelSet(const FloatGrid& field, float band);

/// Of a level set whose band is too narrow by up to `voxels`: what it has is kept, what is beyond is swept.
FloatGrid::Ptr widenedLevelSet(const FloatGrid& levelSet, int voxels, float band);

}  // namespace slicemorph
