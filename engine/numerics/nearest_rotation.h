#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// The rotation R (of determinant 1) that maximises the trace of R^T S [Kab76]. With S the sum of the outer products
/// b a^T, it is the one that carries the points a onto the points b best.
Mat3d nearestRotation(const Mat3d& s);

/// The same from a rotation near it, several times as fast: by Newton's steps while these lead to it, else as above.
Mat3d nearestRotation(const Mat3d& s, const Mat3d& start);

/// Adds the outer product `weight` b a^T to a sum for nearestRotation.
inline void addOuter(Mat3d& sum, double weight, const Vec3d& b, const Vec3d& a) {
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) sum(r, c) += weight * b[r] * a[c];
}

}  // namespace slicemorph
