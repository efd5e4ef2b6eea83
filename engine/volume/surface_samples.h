#pragma once

#include "slicemorph/mesh.h"

#include <cstdint>

namespace slicemorph {

struct SurfacePoint {
  Vec3d point;
  Vec3d normal;  ///< of its triangle: a unit vector
  std::uint32_t triangle;
};

/// About `count` points spread evenly over the area of the listed triangles, in their order; none where they have no
/// area. The same triangles give the same points.
std::vector<SurfacePoint> sampleSurface(const Mesh& mesh, const std::vector<std::uint32_t>& triangles,
                                        size_t count);

/// The k-th point of an even sequence in [0, 1) (the first power of `step` is its stride, see [Rob18]).
inline double evenSequence(size_t k, double step) {
  const double x = 0.5 + double(k) * step;
  return x - double(std::uint64_t(x));
}

}  // namespace slicemorph
