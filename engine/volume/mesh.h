#pragma once

#include "engine/conventions.h"

namespace slicemorph {

/// Triangle mesh in world space.
struct Mesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
};

}  // namespace slicemorph
