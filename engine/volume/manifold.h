#pragma once

#include "engine/volume/mesh.h"

namespace slicemorph {

/// Makes a closed, consistently wound mesh manifold without moving its surface by more than a small share of a face:
/// edges with four faces or more are cut along the outside, so that bodies touching there part, and points where several
/// fans of faces meet become one point per fan. No two points have the same coordinates, so that the mesh stays manifold
/// in formats that store none but coordinates (STL). A mesh that is all that already comes back unchanged.
/// Precondition: every edge has as many faces in one direction as in the other; else throws GeometryError.
Mesh makeManifold(Mesh mesh);

}  // namespace slicemorph
