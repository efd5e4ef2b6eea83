#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

/// Faces of any number of corners, as files hold them. World space.
struct PolygonMesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<std::uint32_t> corners;        ///< indices into `points`, face after face
  std::vector<std::uint32_t> faceStarts{0};  ///< faces + 1 offsets into `corners`
  std::vector<openvdb::Vec3s> colors = {};   ///< per corner of a face, as the file has them; or none

  size_t importCopies =
      0;  ///< points that the importer copied from others (one a corner): welded without a word
  size_t importDropped = 0;  ///< points of the file that no face uses and the importer left out

  size_t faceCount() const { return faceStarts.size() - 1; }
};

}  // namespace slicemorph
