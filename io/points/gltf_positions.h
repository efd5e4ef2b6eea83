#pragma once

#include "io/mesh/gltf_nodes.h"

#include <string>
#include <string_view>

namespace slicemorph {

/// The points of the meshes of a .glb, which can be replaced; everything else (faces, texture coordinates, materials,
/// pictures) stays as it is.
class GltfPositions {
 public:
  /// Throws IoError for files that are damaged, InputError where points are not plain floats that are shown once:
  /// packed, quantised or sparse, moved by a skin, morph targets or instances.
  GltfPositions(const std::string& path, std::string_view bytes);

  /// World space, in the order of the scene.
  const std::vector<Vec3d>& positions() const { return positions_; }
  bool hasNormals() const { return normals_; }
  /// The file with these positions.
  std::string with(const std::vector<Vec3d>& positions) const;

 private:
  /// The points of an accessor.
  struct Part {
    int accessor = 0;
    size_t count = 0;
    size_t first = 0, stride = 0;  ///< bytes in the binary chunk
    NodeTransform toWorld;
  };

  std::string json_, binary_;
  std::vector<Part> parts_;
  std::vector<Vec3d> positions_;
  bool normals_ = false;
};

}  // namespace slicemorph
