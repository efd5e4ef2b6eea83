#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/guidance.h"

namespace slicemorph {

/// Points of all features on one object, world units, in the features' order: a point, a line's ends, a
/// disk's centre and a point along its normal. Equally many on every object.
std::vector<Vec3d> pointsOn(const std::vector<Feature>& features, size_t object);

/// The rotation about the origin that takes points onto others with the least squared error [Kab76].
Mat3d rotationOnto(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

/// Root mean square distance between rotated points of one object and those of another, after centroids and
/// sizes are made equal, relative to their spread: 0 is a perfect fit, 2 the worst (all opposite). 0 for
/// fewer than two points.
double misfit(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to, const Mat3d& rotation);

/// The rotations that corresponding points of two objects suggest: the best fit; where all points lie on a
/// line, four quarter turns about it; none for fewer than two points.
std::vector<Mat3d> turnsOf(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

}  // namespace slicemorph
