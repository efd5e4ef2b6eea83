#pragma once

#include "io/mesh/glb_accessor.h"

#include <map>
#include <memory>
#include <string>
#include <string_view>

namespace slicemorph {

/// A mesh that Draco has unpacked.
struct DracoMesh {
  size_t points = 0;
  std::vector<std::uint32_t> corners;  ///< three to a triangle
  struct Attribute {
    GltfVectors vectors;
    double most = 0;  ///< the largest value of its integers; 0: they are floats
  };
  std::map<int, Attribute> attributes;  ///< by their unique number
};

/// Unpacks KHR_draco_mesh_compression data. Throws GltfDamage.
DracoMesh unpackDraco(std::string_view packed);

}  // namespace slicemorph
