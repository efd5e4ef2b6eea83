#pragma once

#include "io/mesh/assimp_scene.h"

#include <string>
#include <vector>

namespace slicemorph {

/// Diffuse colours (Kd) by the names of the materials that have one, of the .mtl files that an OBJ names, as
/// far as they are there. `named`: what stands behind its `mtllib` words: a name, which may have spaces, or
/// several. Throws IoError for colours that are not finite.
MaterialColors readMaterialColors(const std::string& objPath, const std::vector<std::string>& named);

}  // namespace slicemorph
