#pragma once

#include "engine/volume/repair_mesh.h"

#include <string>

namespace slicemorph {

/// A mesh as a file holds it, in world space (the node transforms of a GLB applied).
struct StoredMesh {
  PolygonMesh mesh;
  size_t points = 0, faces = 0;  ///< in the file; `mesh` may have more or fewer points
  size_t skipped = 0;            ///< points and lines, which have no surface
  bool endsInLine = false;       ///< a text file whose last line has no end: maybe cut short
};

/// True for `.obj .ply .stl .off .glb`, with the dot and in lower case.
bool isMeshExtension(const std::string& extension);

/// Reads `.obj .ply .stl .off .glb`. Throws IoError: missing, empty, truncated, damaged, points that are not finite.
StoredMesh readPolygons(const std::string& path);

/// The closed surface of a mesh that was read. Throws GeometryError and IoError naming `path`.
RepairedMesh closeSurface(const std::string& path, const StoredMesh& stored);

}  // namespace slicemorph
