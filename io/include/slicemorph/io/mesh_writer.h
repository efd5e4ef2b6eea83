#pragma once

#include "slicemorph/mesh.h"

#include <string>

namespace slicemorph {

/// Writes a mesh by extension: `.obj`, `.ply` (binary, little endian), `.stl` (binary), `.glb`
/// (glb_writer.h). Numbers in text are the shortest that are read back as the same floats, in any locale.
/// Colours of points are written too: in PLY as bytes, clamped to 0 to 1 and rounded, in OBJ after the
/// coordinates; STL has none. The file appears whole or not at all. Throws InputError for another
/// extension, and IoError.
void writeMesh(const std::string& path, const Mesh& mesh);

}  // namespace slicemorph
