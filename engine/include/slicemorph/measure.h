#pragma once

#include "slicemorph/mesh.h"

/// Size, topology, distance and overlap of shapes.
namespace slicemorph {

struct ShapeMeasures {
  double volume = 0;  ///< world units cubed
  double area = 0;    ///< world units squared
  int pieces = 0;     ///< connected parts of the inside (26 neighbours never join what the surface separates)
  int genus = 0;      ///< summed over all closed surfaces, from the Euler characteristic
};

/// Volume, area and topology of a level set, measured on its surface mesh.
ShapeMeasures measureShape(const FloatGrid& levelSet);

/// The same of a mesh wound outwards. Shells are parts connected over edges, so that surfaces that only touch
/// at a point stay apart; a shell of positive volume is a piece, one of negative volume the wall of a cavity.
ShapeMeasures measureMesh(const Mesh& mesh);

/// Distances between two surfaces, both ways, in world units.
struct SurfaceDistance {
  double mean = 0;
  double p99 = 0;
  double max = 0;
};

/// Symmetric surface distance: every vertex of each surface mesh against the closest point of the other mesh,
/// the vertices of both directions taken together. Throws GeometryError where a mesh has no triangles.
SurfaceDistance surfaceDistance(const Mesh& a, const Mesh& b);

struct Overlap {
  double dice = 0;                 ///< 1 where both are empty
  double intersection = 0;         ///< world units cubed
  double symmetricDifference = 0;  ///< world units cubed
};

/// Overlap of the insides of two level sets (their voxel sizes may differ; sub-voxel accurate). It is
/// measured on the finer of the two grids and looks at the narrow bands only: what lies deeper inside is
/// counted by whole blocks.
Overlap overlap(const FloatGrid& a, const FloatGrid& b);

}  // namespace slicemorph
