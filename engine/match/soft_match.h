#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Samples of a surface, N each.
struct OrientedPoints {
  std::vector<Vec3d> position;
  std::vector<Vec3d> normal;  ///< unit length
  std::vector<double> mass;   ///< share of the whole area; sum 1
};

/// Per point of one surface, its target on the other.
struct SoftTargets {
  std::vector<Vec3d> position;
  std::vector<double> trust;  ///< share of the point's mass that is transported, 0 to about 1
};

struct SoftMatch {
  SoftTargets aToB, bToA;
};

/// Entropic optimal transport between two surfaces [Cut13], unbalanced [CPSV18] and debiased by each
/// surface's transport onto itself [FSV19]. Every part of a shape gets a partner and no two share one, so
/// that limbs go to limbs where closest points would collapse them. `blur`: length scale of the kernel, in
/// the points' units; smaller details are not resolved. Symmetric in a and b; identical surfaces are mapped
/// onto themselves.
SoftMatch softMatch(const OrientedPoints& a, const OrientedPoints& b, double blur);

}  // namespace slicemorph
