#pragma once

#include "tools/job/option_set.h"

namespace slicemorph {

/// How inputs are read: --voxel-size, --resolution, --iso, --image, --spacing, --memory, as far as the command has
/// them. Throws InputError.
LoadOptions loadSettings(const OptionSet& options);

/// The limit of --memory, or the share of what is free that may be taken without it. Throws InputError.
MemoryLimit memorySettings(const OptionSet& options);

}  // namespace slicemorph
