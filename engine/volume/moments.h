#pragma once

#include "engine/volume/distance_field.h"

namespace slicemorph {

/// Moments of an object's inside, world units.
struct Moments {
  double volume = 0;
  Vec3d centroid{0, 0, 0};
  Mat3d covariance = Mat3d::zero();
};

/// Computed from the coarse distances; each node is weighted by the share of its cell that is inside. Throws
/// GeometryError if nothing is.
Moments insideMoments(const DistanceField& field);

/// Eigenvectors as the columns of a rotation, in the order of descending eigenvalues.
struct PrincipalAxes {
  Mat3d axes = Mat3d::identity();
  Vec3d variances{1, 1, 1};
};
PrincipalAxes principalAxes(const Mat3d& covariance);

}  // namespace slicemorph
