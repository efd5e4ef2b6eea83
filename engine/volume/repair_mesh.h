#pragma once

#include "engine/volume/fill_holes.h"
#include "engine/volume/polygon_mesh.h"
#include "slicemorph/mesh.h"
#include "slicemorph/note.h"

namespace slicemorph {

/// Connectivity of a mesh after duplicate points and faces are removed and windings agree, before
/// holes are filled.
struct MeshTopology {
  size_t shells = 0;         ///< parts connected through shared edges
  size_t boundaryEdges = 0;  ///< edges with one face
  size_t boundaryLoops = 0;
  double longestLoop = 0;       ///< world units, along the edges
  double diagonal = 0;          ///< of the bounding box, world units
  size_t nonManifoldEdges = 0;  ///< edges with three faces or more
  /// Edges across which windings cannot be made to agree; above 0 only on surfaces that are not orientable.
  size_t twistedEdges = 0;
  double signedVolume = 0;  ///< world units cubed, with the winding as found
  size_t weldedPoints = 0, unusedPoints = 0;
};

/// A mesh of triangles with points welded and windings that agree, before anything is closed.
struct CleanedMesh {
  Mesh mesh;
  std::vector<std::uint32_t> patch, piece, shell;  ///< per triangle, from AgreedWinding
  BoundaryLoops boundary;
  MeshTopology found;
  Notes notes;  ///< what was changed, with counts
};

struct RepairedMesh {
  Mesh mesh;  ///< closed; every shell that is closed by itself is wound outwards
  MeshTopology found;
  Notes notes;                        ///< what was changed, with counts
  std::vector<std::uint32_t> turned;  ///< triangles of the shells that were turned outwards
};

/// Longest boundary loop that is filled, relative to the diagonal of the bounding box. The largest
/// hole of the Stanford bunny, in its base, measures 0.45; the open end of a tube as long as it is wide, 2.2.
constexpr double kLargestHole = 0.5;

/// Triangulates faces (concave ones by ear clipping), welds points with equal coordinates, drops unused points and
/// degenerate and duplicate faces, makes windings agree across edges with two faces. Faces must index `points`.
/// Throws GeometryError if there are no faces.
CleanedMesh cleanMesh(const PolygonMesh& mesh);

/// Why closeMesh would not make a closed surface of it, with the numbers; empty if it would.
std::string whyNotClosed(const CleanedMesh& mesh);

/// Fills holes of at most kLargestHole with the triangulation of least area [BS95], and turns inside-out shells.
/// Shells may touch or intersect. A cavity (a shell inside another) is turned outwards, too; a note says so.
RepairedMesh closeMesh(CleanedMesh mesh);

/// All of it. Throws GeometryError, with the numbers, if the surface is open, not orientable, or has no faces.
RepairedMesh repairMesh(const PolygonMesh& mesh);

/// What repairMesh finds, without changing anything. Throws nothing but std::bad_alloc.
MeshTopology inspectMesh(const PolygonMesh& mesh);

}  // namespace slicemorph
