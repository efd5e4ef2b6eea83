#pragma once

#include "tools/job/option_set.h"

namespace slicemorph {

/// How inputs are read: --voxel-size, --resolution, --iso, --image, --spacing, as far as the command has
/// them. Throws InputError.
LoadOptions loadSettings(const OptionSet& options);

}  // namespace slicemorph
