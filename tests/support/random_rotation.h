#pragma once

#include "slicemorph/conventions.h"

#include <openvdb/math/Quat.h>

#include <random>

namespace slicemorph {

/// A rotation about any axis by any angle, all alike likely.
inline Mat3d randomRotation(std::mt19937& random) {
  // Four normal deviates are a random rotation's quaternion but for their length.
  std::normal_distribution<double> normal;
  openvdb::math::Quat<double> q(normal(random), normal(random), normal(random), normal(random));
  q.normalize();
  return Mat3d(q);
}

}  // namespace slicemorph
