#pragma once

#include "slicemorph/mesh.h"

namespace slicemorph {

struct ManifoldMesh {
  Mesh mesh;
  /// Points that could not be separated from another: the surface there has no extent.
  size_t coincident = 0;
};

/// Makes a closed, consistently wound mesh manifold, moving its surface by no more than a small share of a
/// face. Edges with four or more faces are split so that the bodies that touch there separate; points where
/// several fans of faces meet are split into one point per fan. Points with equal coordinates are moved
/// apart, so that the mesh stays manifold in formats that store coordinates only (STL). A mesh that is
/// already manifold is returned unchanged. Throws GeometryError unless every edge has as many faces in one
/// direction as in the other.
ManifoldMesh makeManifold(Mesh mesh);

}  // namespace slicemorph
