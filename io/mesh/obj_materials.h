#pragma once

#include "io/mesh/assimp_scene.h"

#include <string>
#include <vector>

namespace slicemorph {

/// Reads the diffuse colours (Kd) of the .mtl files that an OBJ names; missing files are left out. `named`:
/// for each `mtllib` line the text after that word: one name, which may have spaces, or several names. Throws
/// IoError for colours that are not finite.
MaterialColors readMaterialColors(const std::string& objPath, const std::vector<std::string>& named);

}  // namespace slicemorph
