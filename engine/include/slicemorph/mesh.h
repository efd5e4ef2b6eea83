#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Triangle mesh in world space.
struct Mesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec3s> colors = {};  ///< per point: red, green, blue as in the input; or empty
};

}  // namespace slicemorph
