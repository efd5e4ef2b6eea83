#pragma once

#include "slicemorph/mesh.h"

#include <string>

namespace slicemorph {

/// What a mesh file says of its coordinate system, as 3D Slicer reads it ("SPACE=LPS"): in the header of STL, a
/// comment of PLY and OBJ, a field of VTP; glTF has no place for it. kUnsaid: nothing.
enum class MeshSpace { kUnsaid, kLps, kRas };

/// Writes a mesh by extension: `.obj`, `.ply` (binary, little endian), `.stl` (binary), `.glb` (glb_writer.h), `.vtp`
/// (VTK XML PolyData, binary). Points are in LPS; for kRas they are turned about z by half a turn. Numbers in text are the shortest that are read back as the same floats, in any locale.
/// Colours of points are written too: in PLY as bytes, clamped to 0 to 1 and rounded, in OBJ after the
/// coordinates; STL has none. The file appears whole or not at all. Throws InputError for another
/// extension, and IoError.
void writeMesh(const std::string& path, const Mesh& mesh, MeshSpace space = MeshSpace::kUnsaid);

}  // namespace slicemorph
