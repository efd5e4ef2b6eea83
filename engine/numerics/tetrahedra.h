#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// The corners of the six tetrahedra of a lattice cell (Kuhn's subdivision [Kuh60], which matches across
/// faces), as bits x, y, z. Each tetrahedron goes from corner 000 to 111 along one order of the axes; odd
/// orders have two corners swapped so that all six have positive volume.
constexpr int kKuhnTetrahedra[6][4] = {{0, 1, 3, 7}, {0, 5, 1, 7}, {0, 3, 2, 7},
                                       {0, 2, 6, 7}, {0, 4, 5, 7}, {0, 6, 4, 7}};

/// Six times the signed volume of a tetrahedron of a cell's `corners`. For each of Kuhn's tetrahedra of an
/// undistorted cell that is the cell's volume.
inline double parallelepipedVolume(const Vec3d* corners, const int* tetrahedron) {
  const Vec3d& first = corners[tetrahedron[0]];
  return (corners[tetrahedron[1]] - first)
      .cross(corners[tetrahedron[2]] - first)
      .dot(corners[tetrahedron[3]] - first);
}

}  // namespace slicemorph
