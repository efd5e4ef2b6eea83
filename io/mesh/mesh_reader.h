#pragma once

#include "engine/volume/solid_of_mesh.h"
#include "slicemorph/io/input_spec.h"

#include <functional>
#include <string>

namespace slicemorph {

/// A mesh as a file holds it, in world space (the node transforms of a GLB applied).
struct StoredMesh {
  PolygonMesh mesh;
  /// What is to be added to the mesh's points for their place in the world. It is 0 but for what lies many of its own
  /// lengths away, as maps do, where single precision has no digits left for the shape.
  Vec3d origin{0, 0, 0};
  std::vector<openvdb::Vec3s> rests =
      {};                        ///< while reading, per point: what it lost in single precision; or empty
  size_t points = 0, faces = 0;  ///< as the file counts them; `mesh` may have more or fewer points
  size_t skipped = 0;            ///< points and lines, which have no surface
  bool endsInLine = false;       ///< a text file whose last line has no newline: maybe cut short
  std::string colorsOf;  ///< what has colours: "points", "faces", "materials", "textures"; empty: nothing
  Notes notes = {};      ///< what else was changed or left out

  /// Of a reader that adds all its points so.
  void addPoint(const Vec3d& point) {
    mesh.points.emplace_back(point);
    rests.emplace_back(point - Vec3d(mesh.points.back()));
  }
};

/// Reads a mesh of any format of the table. Colours: of PLY and OFF the points' own, else the faces'; of OBJ a
/// material's map_Kd times its Kd, else the points' own, else Kd (none without an .mtl); of glTF COLOR_0 times the
/// material's baseColorFactor and baseColorTexture. Parts without a colour are white where others have one. Values
/// are the file's, integers divided by the largest value of their type: PLY and OBJ files tend to hold sRGB, glTF
/// linear values, and neither is converted. Pictures are sRGB and are decoded to linear light.
/// Throws IoError for a file that is missing, empty, truncated or damaged, or whose points or colours
/// are not finite.
StoredMesh readPolygons(const InputSpec& input);

/// The solid that a mesh is, closed or not, with notes on the file before those on repairs. Throws, naming `path`,
/// what solidOf throws, and IoError for a surface with holes in a file that seems cut short (`endsInLine`). `check` is
/// called before anything is voxelised, and may throw.
MeshSolid solidOfFile(const std::string& path, const StoredMesh& stored, const SolidOptions& options,
                      const std::function<void(const SolidMesh&)>& check);

/// What solidOfFile would note or throw, without voxelising.
Notes checkSolid(const std::string& path, const StoredMesh& stored, const SolidOptions& options);

}  // namespace slicemorph
