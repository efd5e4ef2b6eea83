#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Moves world points onto the surface of a level set: along its gradient; points beyond its narrow band are
/// first moved to the nearest surface point. Throws GeometryError for one without a surface.
std::vector<Vec3d> ontoSurface(std::vector<Vec3d> points, const FloatGrid& levelSet);

/// The share of a mesh's area whose triangles face into the level set, 0 to 1; the mesh's points must be on
/// its surface.
double shareFacingInwards(const Mesh& mesh, const FloatGrid& levelSet);

}  // namespace slicemorph
