#pragma once

#include "slicemorph/mesh.h"

namespace slicemorph {

struct ManifoldMesh {
  Mesh mesh;
  size_t coincident =
      0;  ///< points that could not be parted from another: they lie on a surface without extent
};

/// Makes a closed, consistently wound mesh manifold without moving its surface by more than a small share of
/// a face: edges with four faces or more are cut along the outside, so that bodies touching there part, and
/// points where several fans of faces meet become one point per fan. Points with the coordinates of another
/// are moved apart, so that the mesh stays manifold in formats that store none but coordinates (STL). A mesh
/// that is all that already comes back unchanged. Precondition: every edge has as many faces in one direction
/// as in the other; else throws GeometryError.
ManifoldMesh makeManifold(Mesh mesh);

}  // namespace slicemorph
