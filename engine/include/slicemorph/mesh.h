#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Triangle mesh in world space.
struct Mesh {
  std::vector<openvdb::Vec3s> points;
  std::vector<openvdb::Vec3I> triangles;
  std::vector<openvdb::Vec3s> colors = {};  ///< per point: red, green, blue as in the input; or empty
  /// To be added to all points. 0 but in what is written to files (meshForFile), where single precision has no digits
  /// left for a shape that lies far away.
  Vec3d origin{0, 0, 0};
};

}  // namespace slicemorph
