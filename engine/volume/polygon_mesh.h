#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

/// Faces with any number of corners, as files store them. World space.
struct PolygonMesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<std::uint32_t> corners;        ///< indices into `points`, face after face
  std::vector<std::uint32_t> faceStarts{0};  ///< faces + 1 offsets into `corners`
  std::vector<openvdb::Vec3s> colors = {};   ///< per corner of a face, as in the file; or empty

  /// Points that the importer duplicated (one per corner); welding them is not reported.
  size_t importCopies = 0;
  size_t importDropped = 0;  ///< points of the file that no face uses, which the importer left out

  size_t faceCount() const { return faceStarts.size() - 1; }
};

}  // namespace slicemorph
