#pragma once

#include "slicemorph/measure.h"

namespace slicemorph {

/// One way: every point (world) against the closest point of the mesh. Throws GeometryError where either is
/// empty.
SurfaceDistance distanceTo(const std::vector<openvdb::Vec3s>& points, const Mesh& mesh);

}  // namespace slicemorph
