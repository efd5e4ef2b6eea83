#pragma once

#include "slicemorph/measure.h"

namespace slicemorph {

/// Distances in one direction: of every point (world) to the closest point of the mesh. Throws GeometryError
/// if either is empty.
SurfaceDistance distanceTo(const std::vector<openvdb::Vec3s>& points, const Mesh& mesh);

}  // namespace slicemorph
