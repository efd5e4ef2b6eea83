#pragma once

#include "io/mesh/mesh_reader.h"

#include <openvdb/math/Vec3.h>

#include <map>
#include <string>

namespace slicemorph {

/// Diffuse colours by the name of a material.
using MaterialColors = std::map<std::string, openvdb::math::Vec3s>;

/// Reads the polygons of a file through assimp, in world space. The caller has checked that the file is
/// whole. Colours are the points' own, else those of `materials`; where that is null, no colours are
/// read. Throws IoError.
StoredMesh importScene(const std::string& path, const MaterialColors* materials = nullptr);

}  // namespace slicemorph
