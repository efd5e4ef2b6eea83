#pragma once

#include <cstddef>
#include <string>

namespace slicemorph {

/// What a mesh file says of itself.
struct MeshCounts {
  size_t points = 0, faces = 0;
  size_t unusedPoints = 0;   ///< OBJ only: the importer drops these unseen
  bool endsInLine = false;   ///< a text file whose last line has no end: maybe cut short
};

/// Checks that a mesh file is whole, which assimp does not: it reads a PLY cut in two without a word and makes up the
/// rest. Counts are compared with the header's (PLY, STL, OFF, GLB) or the lines themselves (OBJ).
/// Throws IoError naming the file, the line and what is missing.
MeshCounts checkMeshFile(const std::string& path);

}  // namespace slicemorph
