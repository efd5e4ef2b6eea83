#pragma once

#include "tools/job/option_set.h"

namespace slicemorph {

/// How inputs are read: --voxel-size, --resolution, --iso, --image, --spacing, those of them that the command
/// has. Throws InputError.
LoadOptions loadSettings(const OptionSet& options);

}  // namespace slicemorph
