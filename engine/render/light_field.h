#pragma once

#include "slicemorph/conventions.h"

#include <vector>

namespace slicemorph {

/// How much of a far light arrives everywhere in a fog: what is not absorbed on the straight way there, and
/// an estimate of what is scattered on towards it (octaves of [WKL13]). Kept on a lattice along
/// the light, so that one pass of running sums makes it.
class LightField {
 public:
  /// `density`: not empty, any linear transform. `towards`: the light, world, unit length. `extinction`: per
  /// world unit at density 1.
  LightField(const FloatGrid& density, const Vec3d& towards, double extinction);

  /// 1: all of it. World point; beyond the fog that of the nearest place.
  float at(const Vec3d& world) const;

 private:
  Vec3d axes_[3];       // across, across, away from the light; unit length
  Vec3d origin_;        // of the lattice: the first node's coordinates along the axes
  double spacing_ = 1;  // world units
  openvdb::Coord size_;
  std::vector<float> light_;  // the way along the light fastest
};

}  // namespace slicemorph
