#pragma once

#include "io/mesh/mesh_reader.h"
#include "io/mesh/mesh_text.h"

/// What the readers of scenes, whose meshes come in parts with colours of their own, share.
namespace slicemorph {

/// Where one part's points lie among those of all parts.
struct ScenePart {
  size_t first = 0;   ///< index of its first point
  size_t points = 0;  ///< how many it has
};

/// Appends a corner of face `face` (of its part, from 0). `point`: of the part, from 0. `colors`: `at(point)` is
/// a point's colour. Throws IoError naming `path`: the part has no such point, or its colour is not finite.
template <class Colors>
void addCorner(const std::string& path, PolygonMesh& mesh, const ScenePart& part, size_t face,
               std::uint32_t point, const Colors& colors) {
  if (point >= part.points) refuseCorner(path, face, point, part.points);
  mesh.corners.push_back(std::uint32_t(part.first + point));
  mesh.colors.push_back(colors.at(point));
  if (!isFinite(mesh.colors.back()))
    refuseNotFinite(path, "the colour of point " + std::to_string(mesh.corners.back() + 1),
                    mesh.colors.back());
}

/// Whose the colours are, once a part has some: of "points" or of "materials" (points win).
template <class Colors>
void noteColors(StoredMesh& stored, const Colors& colors) {
  if (colors.any() && stored.colorsOf != "points") stored.colorsOf = colors.ofPoints ? "points" : "materials";
}

}  // namespace slicemorph
