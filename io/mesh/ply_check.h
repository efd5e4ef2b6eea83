#pragma once

#include "io/mesh/ply_header.h"

#include <string>
#include <string_view>

namespace slicemorph {

/// Throws IoError where a PLY file's body ends before all that its header announces; assimp and most other
/// readers silently make up the rest. `bytes`: the whole file.
void checkPlyBody(const std::string& path, std::string_view bytes, const PlyHeader& header);

}  // namespace slicemorph
