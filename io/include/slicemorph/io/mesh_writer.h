#pragma once

#include "slicemorph/mesh.h"

#include <string>

namespace slicemorph {

/// Writes a mesh by extension: `.obj`, `.ply` (binary, little endian), `.stl` (binary), `.glb`
/// (glb_writer.h). Numbers of text files are the shortest that read back as the same floats, whatever the
/// locale. Colours of points go along: in PLY as bytes, to the nearest and within 0 to 1, in OBJ behind the
/// coordinates; STL has none. Whole or not at all; throws IoError.
void writeMesh(const std::string& path, const Mesh& mesh);

}  // namespace slicemorph
