#pragma once

#include "slicemorph/mesh.h"

/// Size, topology, distance and overlap of shapes.
namespace slicemorph {

struct ShapeMeasures {
  double volume = 0;  ///< world units cubed
  double area = 0;    ///< world units squared
  int pieces = 0;     ///< closed surfaces of positive volume, not counting the walls of cavities
  int genus = 0;      ///< summed over all closed surfaces, from the Euler characteristic
};

/// Volume, area and topology of a level set, measured on its surface mesh.
ShapeMeasures measureShape(const FloatGrid& levelSet);

/// The same for a mesh wound outwards. Shells are components connected over edges, so surfaces that touch
/// only at a point are separate; a shell of positive volume is a piece, one of negative volume the wall
/// of a cavity.
ShapeMeasures measureMesh(const Mesh& mesh);

/// Symmetric distance between two surfaces, world units.
struct SurfaceDistance {
  double mean = 0;
  double p95 = 0;  ///< 95 % of them are shorter
  double p99 = 0;
  double max = 0;
};

/// Distances of all vertices of each mesh to the closest point of the other mesh, both directions taken
/// together. Throws GeometryError if a mesh has no triangles.
SurfaceDistance surfaceDistance(const Mesh& a, const Mesh& b);

struct Overlap {
  double dice = 0;                 ///< 1 if both are empty
  double intersection = 0;         ///< world units cubed
  double symmetricDifference = 0;  ///< world units cubed
};

/// Overlap of the insides of two level sets (voxel sizes may differ; sub-voxel accurate). Measured on the finer of
/// the two grids; where resampling the other to it would take much memory, each volume on its own, and what they
/// share on the finer one's voxels. Only the narrow bands are read; what is deeper inside is counted in whole blocks.
Overlap overlap(const FloatGrid& a, const FloatGrid& b);

}  // namespace slicemorph
