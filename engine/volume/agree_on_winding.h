#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>

namespace slicemorph {

struct AgreedWinding {
  std::vector<openvdb::Vec3I> triangles;
  std::vector<std::uint32_t> patch;  ///< per triangle: its set across edges with two faces
  size_t shells = 0;                 ///< sets across any edge
  size_t nonManifold = 0;            ///< edges with more than two faces
  size_t twisted = 0;                ///< edges with two faces across which no winding agrees
  size_t turned = 0;                 ///< triangles whose winding was changed
};

/// Makes the winding agree across edges with two faces; each patch follows its majority.
AgreedWinding agreeOnWinding(std::vector<openvdb::Vec3I> triangles);

}  // namespace slicemorph
