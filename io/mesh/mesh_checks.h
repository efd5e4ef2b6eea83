#pragma once

#include <cstddef>
#include <string>
#include <vector>

namespace slicemorph {

/// What a mesh file says of itself.
struct MeshCounts {
  size_t points = 0, faces = 0;
  size_t unusedPoints = 0;  ///< OBJ only: the importer drops these unseen
  bool endsInLine = false;  ///< a text file whose last line has no end: maybe cut short
  std::vector<std::string> materialFiles =
      {};  ///< OBJ only: what stands behind each `mtllib`, if materials are used
};

/// Checks that a mesh file is whole, which assimp does not: it reads a PLY cut in two without a word and
/// makes up the rest. Counts are compared with the header's (PLY, STL, OFF, GLB) or the lines themselves
/// (OBJ); colours that only some vertices have are refused (OBJ, GLB). Throws IoError naming the file, the
/// line and what is missing.
MeshCounts checkMeshFile(const std::string& path);

}  // namespace slicemorph
