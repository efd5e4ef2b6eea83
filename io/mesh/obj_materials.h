#pragma once

#include <openvdb/math/Vec3.h>

#include <map>
#include <string>
#include <vector>

namespace slicemorph {

/// Diffuse colours (Kd) by the names of the materials that have one, of the .mtl files that an OBJ names, as
/// far as they are there. `named`: what stands behind its `mtllib` words: a name, which may have spaces, or
/// several. Throws IoError for colours that are not finite.
std::map<std::string, openvdb::math::Vec3s> readMaterialColors(const std::string& objPath,
                                                               const std::vector<std::string>& named);

}  // namespace slicemorph
