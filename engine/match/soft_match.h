#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Points of a surface with their normals and shares of the whole area (sum 1).
struct OrientedPoints {
  std::vector<Vec3d> position;
  std::vector<Vec3d> normal;
  std::vector<double> mass;
};

/// Where each point of one surface goes on the other, and how much of its mass finds a place there (0 to
/// about 1).
struct SoftTargets {
  std::vector<Vec3d> position;
  std::vector<double> trust;
};

struct SoftMatch {
  SoftTargets aToB, bToA;
};

/// Entropic optimal transport between two surfaces, unbalanced and debiased by each surface's transport onto
/// itself [Cut13], [CPSV18], [FSV19]: every part of a shape looks for a partner and
/// no two share one, so limbs go to limbs where the nearest point would collapse them. `blur`: length below
/// which the match is not sharp, in the points' units. Symmetric in a and b; identical surfaces go onto
/// themselves.
SoftMatch softMatch(const OrientedPoints& a, const OrientedPoints& b, double blur);

}  // namespace slicemorph
