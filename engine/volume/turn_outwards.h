#pragma once

#include "slicemorph/mesh.h"

#include <cstdint>

namespace slicemorph {

/// Volume of the tetrahedron from a point to a triangle: positive where the triangle is seen from its back. Summed over
/// a closed mesh, the volume that it encloses.
double signedVolume(const std::vector<openvdb::Vec3s>& points, const openvdb::Vec3I& triangle,
                    const Vec3d& origin);

struct TurnedParts {
  size_t insideOut = 0;  ///< parts that were turned
  size_t cavities = 0;   ///< parts inside others
};

/// A closed part is a cavity where it lies inside a part of the opposite sense; any other is turned outwards. Triangles
/// outside closed parts keep their winding: they have no inside of their own. `patch`: per triangle, that of
/// AgreedWinding.
TurnedParts turnOutwards(Mesh& mesh, const std::vector<std::uint32_t>& patch);

}  // namespace slicemorph
