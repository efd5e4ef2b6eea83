#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

namespace slicemorph {

/// What a scan of an OBJ file's lines finds.
struct ObjCounts {
  size_t points = 0, faces = 0;
  size_t unusedPoints = 0;                 ///< in no face; assimp drops them silently
  bool endsInLine = false;                 ///< its last line has no newline: maybe cut short
  std::vector<std::string> materialFiles;  ///< text after each `mtllib`; empty where no material is used
};

/// Checks that an OBJ file is whole, which assimp does not: faces refer to vertices that are
/// there, numbers are
/// finite, all vertices or none have colours. Throws IoError naming the file, the line and what is missing.
ObjCounts scanObj(const std::string& path, std::string_view bytes);

}  // namespace slicemorph
