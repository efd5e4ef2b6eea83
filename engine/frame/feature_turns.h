#pragma once

#include "slicemorph/conventions.h"
#include "slicemorph/guidance.h"

namespace slicemorph {

/// The places that features name on one object, in their order: as many on every object.
std::vector<Vec3d> pointsOn(const std::vector<Feature>& features, size_t object);

/// The rotation that carries points onto others best, about the origin [Kab76].
Mat3d rotationOnto(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

/// What a rotation leaves over between places of two objects, position and size apart: root mean square by their
/// spread; 0 is a perfect fit, 2 the other way round. 0 for fewer than two places.
double misfit(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to, const Mat3d& rotation);

/// The rotations that places of two objects suggest: the one that fits best; four about a line on which all lie;
/// none where there are fewer than two.
std::vector<Mat3d> turnsOf(const std::vector<Vec3d>& from, const std::vector<Vec3d>& to);

}  // namespace slicemorph
