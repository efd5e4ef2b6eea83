#pragma once

#include "engine/volume/texture.h"
#include "slicemorph/conventions.h"

#include <cstdint>
#include <memory>

namespace slicemorph {

/// Faces with any number of corners, as files store them. World space.
struct PolygonMesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<std::uint32_t> corners;        ///< indices into `points`, face after face
  std::vector<std::uint32_t> faceStarts{0};  ///< faces + 1 offsets into `corners`
  std::vector<openvdb::Vec3s> colors = {};   ///< per corner of a face, as in the file; or empty

  /// Pictures on faces; or none. The colour of a place is that between its face's corners times the picture's.
  std::vector<std::shared_ptr<const Texture>> textures = {};
  std::vector<int> textureOfFace = {};   ///< per face an index into `textures`, -1: none; or empty
  std::vector<openvdb::Vec2s> uvs = {};  ///< per corner, where its face has a picture; or empty

  /// Points that the importer duplicated (one per corner); welding them is not reported.
  size_t importCopies = 0;

  size_t faceCount() const { return faceStarts.size() - 1; }
};

}  // namespace slicemorph
