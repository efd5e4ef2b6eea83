#pragma once

#include "io/mesh/mesh_reader.h"

#include <openvdb/math/Vec3.h>

#include <map>
#include <string>

namespace slicemorph {

/// Colours by the name of a material.
using MaterialColors = std::map<std::string, openvdb::math::Vec3s>;

/// Reads the polygons of a file that was found whole through assimp, part by part. `materials`: take colours, of
/// points or of these materials; null: none. Throws IoError.
StoredMesh importScene(const std::string& path, const MaterialColors* materials = nullptr);

}  // namespace slicemorph
