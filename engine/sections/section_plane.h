#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Position of a slice in the world: the centre of pixel (i, j), i to the right and j downwards in the image,
/// is at origin + pixelSize * (i * xAxis + j * yAxis). The axes are orthonormal and right-handed: normal =
/// xAxis x yAxis.
struct SectionPlane {
  int index = 0;  ///< 0 to count - 1
  int count = 0;
  /// -1 to 1 from the first to the last of the slabs of equal thickness; for given planes by their number.
  double u = 0;
  Vec3d origin{0, 0, 0};
  Vec3d xAxis{1, 0, 0};
  Vec3d yAxis{0, 1, 0};
  Vec3d normal{0, 0, 1};
  double pixelSize = 1;  ///< world units
  int width = 0;         ///< pixels
  int height = 0;

  Vec3d toWorld(double i, double j) const { return origin + pixelSize * (i * xAxis + j * yAxis); }
  /// Signed distance of a world point from the plane, positive on the normal's side.
  double distance(const Vec3d& p) const { return (p - origin).dot(normal); }
};

}  // namespace slicemorph
