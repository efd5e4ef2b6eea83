#pragma once

#include "engine/volume/repair_mesh.h"
#include "slicemorph/io/input_spec.h"

#include <string>

namespace slicemorph {

/// A mesh as a file holds it, in world space (the node transforms of a GLB applied).
struct StoredMesh {
  PolygonMesh mesh;
  size_t points = 0, faces = 0;  ///< in the file, where it states them; `mesh` may have more or fewer points
  size_t skipped = 0;            ///< points and lines, which have no surface
  bool endsInLine = false;       ///< a text file whose last line has no end: maybe cut short
  std::string colorsOf;          ///< what has colours: "points", "faces", "materials"; empty: nothing
  bool textured = false;         ///< with textures, which are not read
  Notes notes = {};              ///< what else was not taken as the file has it
};

/// Reads a mesh of any format of the table. Colours: of PLY the points' own, else the faces'; of OBJ the points'
/// own, else each material's Kd (none without an .mtl); of GLB COLOR_0 times the material's baseColorFactor.
/// Parts without one are white where others have one. Numbers are the file's, whole ones divided by the
/// largest of their type: PLY and OBJ files tend to hold sRGB, GLB linear values, and neither is converted.
/// Throws IoError: missing, empty, truncated, damaged, points or colours that are not finite.
StoredMesh readPolygons(const InputSpec& input);

/// The closed surface of a mesh that was read. Throws GeometryError and IoError naming `path`.
RepairedMesh closeSurface(const std::string& path, const StoredMesh& stored);

}  // namespace slicemorph
