#pragma once

#include "slicemorph/mesh.h"

#include <cstdint>

namespace slicemorph {

/// Signed volume of the tetrahedron from `origin` to a triangle: positive if the triangle faces away from it.
/// Summed over a closed mesh it is the enclosed volume.
double signedVolume(const std::vector<openvdb::Vec3s>& points, const openvdb::Vec3I& triangle,
                    const Vec3d& origin);

/// Turns triangles over.
void turnOver(Mesh& mesh, const std::vector<std::uint32_t>& triangles);

struct TurnedParts {
  size_t insideOut = 0;                  ///< parts that were turned outwards
  size_t cavities = 0;                   ///< parts inside other parts
  std::vector<std::uint32_t> triangles;  ///< those of the parts that were turned
};

/// Turns closed parts outwards. A part that lies inside one of the opposite orientation is counted as a
/// cavity; it is turned outwards, too. Triangles that are not in closed parts keep their winding, because
/// they enclose nothing. `patch`: per triangle, from AgreedWinding.
TurnedParts turnOutwards(Mesh& mesh, const std::vector<std::uint32_t>& patch);

}  // namespace slicemorph
