#pragma once

#include "io/mesh/mesh_reader.h"

namespace slicemorph {

/// Reads a PLY mesh that checkMeshFile has found whole: any of the three formats, any number types, faces and
/// triangle strips. Colours are the points' own, else the faces' (strips have none and are white among them);
/// whole numbers are divided by the largest of their type. What else the file holds is passed over. (Assimp
/// reads no colours of faces, and garbage where an element that it does not know comes before the points.)
/// Throws IoError.
StoredMesh readPly(const std::string& path);

}  // namespace slicemorph
