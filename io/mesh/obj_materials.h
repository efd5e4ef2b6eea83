#pragma once

#include "engine/volume/texture.h"

#include <map>
#include <optional>
#include <string>
#include <vector>

namespace slicemorph {

/// A picture that map_Kd lays on a surface: its coordinates are `scale` times those of the corners plus `offset`.
struct ObjTexture {
  std::string file;  ///< empty: there is none
  openvdb::Vec2d scale{1, 1}, offset{0, 0};
  TextureSampling sampling = {};
};

/// What an .mtl file says of a surface's colour.
struct ObjMaterial {
  std::optional<openvdb::Vec3s> color;  ///< Kd
  ObjTexture texture;                   ///< map_Kd
};

/// Materials by name.
using ObjMaterials = std::map<std::string, ObjMaterial>;

/// Reads the materials of the .mtl files that an OBJ names; missing files are left out. `named`: for each
/// `mtllib` line the text after that word: one name, which may have spaces, or several names. Throws IoError
/// for colours that are not finite.
ObjMaterials readObjMaterials(const std::string& objPath, const std::vector<std::string>& named);

}  // namespace slicemorph
