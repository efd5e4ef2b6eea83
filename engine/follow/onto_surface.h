#pragma once

#include "engine/conventions.h"

namespace slicemorph {

/// Moves world points onto the surface of a level set (by the conventions): along its gradient, and from beyond its narrow
/// band to the nearest place first. Throws GeometryError for one without a surface.
std::vector<Vec3d> ontoSurface(std::vector<Vec3d> points, const FloatGrid& levelSet);

}  // namespace slicemorph
