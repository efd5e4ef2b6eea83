#pragma once

#include "slicemorph/io/mesh_writer.h"
#include "tools/job/option_set.h"

namespace slicemorph {

/// How inputs are read: --voxel-size, --resolution, --iso, --image, --spacing, --memory, as far as the command has
/// them. Throws InputError.
LoadOptions loadSettings(const OptionSet& options);

/// What mesh files say of their coordinate system by --space; without it `otherwise`. Throws InputError where the
/// output is no mesh.
MeshSpace meshSpace(const OptionSet& options, const std::string& output, MeshSpace otherwise);

/// The limit of --memory, or the share of what is free that may be taken without it. Throws InputError.
MemoryLimit memorySettings(const OptionSet& options);

}  // namespace slicemorph
