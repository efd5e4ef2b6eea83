#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/mesh.h"

namespace slicemorph {

/// Moves world points onto the surface of a level set (by the conventions): along its gradient, and from
/// beyond its narrow band to the nearest place first. Throws GeometryError for one without a surface.
std::vector<Vec3d> ontoSurface(std::vector<Vec3d> points, const FloatGrid& levelSet);

/// The share of a mesh's area whose triangles face into a level set on whose surface its points lie, 0 to 1.
double shareFacingInwards(const Mesh& mesh, const FloatGrid& levelSet);

}  // namespace slicemorph
