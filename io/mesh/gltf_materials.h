#pragma once

#include "io/mesh/gltf_file.h"
#include "io/mesh/texture_set.h"

#include <optional>
#include <string>

namespace slicemorph {

/// What a material gives a surface: a base colour and a picture that is multiplied with it.
struct GltfPaint {
  std::optional<openvdb::Vec3s> color;
  int texture = -1;                     ///< index in the file; -1: none
  std::string coordinates;              ///< attribute with its coordinates, "TEXCOORD_0"
  Mat3d toPicture = Mat3d::identity();  ///< of (u, v, 1): KHR_texture_transform
};

/// The materials of a glTF file: baseColorFactor and baseColorTexture, or diffuseFactor and diffuseTexture of
/// KHR_materials_pbrSpecularGlossiness.
class GltfMaterials {
 public:
  GltfMaterials(const std::string& path, const GltfFile& file) : path_(path), file_(file) {}

  /// `index`: below 0: no material.
  GltfPaint paintOf(int index) const;
  /// Index among the mesh's textures of one of the file's, whose picture is decoded where it is new; -1: it cannot be
  /// read.
  int textureOf(int index);
  /// See TextureSet.
  void finish(StoredMesh& stored) { textures_.finish(stored); }

 private:
  const std::string& path_;
  const GltfFile& file_;
  TextureSet textures_;
};

}  // namespace slicemorph
