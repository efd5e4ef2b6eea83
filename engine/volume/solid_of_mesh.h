#pragma once

#include "engine/volume/repair_mesh.h"

namespace slicemorph {

/// How a mesh becomes a solid. Both lengths in world units.
struct SolidOptions {
  double voxelSize = 0;  ///< 0: the mesh's longest side has `resolution` voxels
  int resolution = 256;
  double shell = 0;  ///< thickness that shells get that enclose nothing; 0: they are left out
};

/// A mesh made ready to be voxelised. Of what is clean and closed everything is in `mesh`, wound outwards.
struct SolidMesh {
  Mesh mesh;                          ///< triangles that enclose something
  Mesh sheets;                        ///< those that do not; the same points
  std::vector<std::uint32_t> turned;  ///< triangles of inside-out shells and cavities that were turned
  bool closed = false;                ///< `mesh` is closed; its inside is what cannot be reached from outside
  size_t shells = 0, sheetShells = 0;  ///< how many, and how many of them are sheets
  MeshTopology found;
  std::string open;  ///< why the surface is not closed, with the numbers; empty if it is
  Notes notes;       ///< what was changed, one each
};

/// Makes any mesh ready. Where it can be closed as it is (small holes, no twisted edges), it is; else its patches are
/// made to face outwards and its shells that enclose nothing are set aside. Throws GeometryError if there are no
/// faces.
SolidMesh prepareSolid(const PolygonMesh& mesh);

/// The voxel size that the options mean for a mesh.
double voxelSizeOf(const SolidMesh& mesh, const SolidOptions& options);

/// Throws GeometryError, with a thickness that would do, if the mesh has only sheets and none is given; InputError for
/// a thickness too small to be seen.
void refuseSheets(const SolidMesh& mesh, const SolidOptions& options);

struct MeshSolid {
  FloatGrid::Ptr levelSet;
  Notes notes;  ///< what was repaired: one for people, and its parts as details
};

/// The level set of a mesh. A mesh that is closed or was made so is voxelised as it is, its inside what cannot be
/// reached from outside, unless winding numbers say otherwise somewhere (cavities, pockets between shells). All others
/// have their inside where the winding number is above 1/2 [JKS13]. Throws as refuseSheets and voxelise.
MeshSolid solidOf(SolidMesh mesh, const SolidOptions& options);

/// Notes on repairs as one that has them all, and they as details.
Notes inOneLine(Notes notes);

}  // namespace slicemorph
