#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// The rotation R (of determinant 1) that maximises the trace of R^T S [Kab76]. With S the sum of the outer products
/// b a^T, it is the one that carries the points a onto the points b best.
Mat3d nearestRotation(const Mat3d& s);

}  // namespace slicemorph
