#pragma once

#include "io/mesh/glb_accessor.h"

#include <memory>
#include <string>
#include <vector>

namespace tinygltf {
struct Primitive;
}

namespace slicemorph {

struct DracoMesh;

/// The vertices of a primitive of a glTF file, in accessors or packed by KHR_draco_mesh_compression, with its
/// morph targets applied.
class GltfVertices {
 public:
  /// `weights`: of the morph targets. Throws GltfDamage.
  GltfVertices(const tinygltf::Model& model, const tinygltf::Primitive& primitive,
               const std::vector<double>& weights);

  size_t count() const { return count_; }
  /// Whether morph targets moved points.
  bool morphed() const { return morphed_; }
  bool has(const std::string& attribute) const;
  size_t countOf(const std::string& attribute) const;

  /// Vectors of at least `width` numbers, one for each vertex. `normalise`: see readGltfVectors. Throws
  /// GltfDamage.
  GltfVectors read(const std::string& attribute, int width, bool normalise = false) const;

  /// The corners of the faces, as indices of vertices, before they are grouped into faces.
  std::vector<std::uint32_t> corners() const;

 private:
  const tinygltf::Model& model_;
  const tinygltf::Primitive& primitive_;
  std::vector<double> weights_;
  std::shared_ptr<const DracoMesh> draco_;
  size_t count_ = 0;
  bool morphed_ = false;
};

}  // namespace slicemorph
