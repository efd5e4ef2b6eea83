#pragma once

#include "slicemorph/conventions.h"

#include <vector>

namespace slicemorph {

/// The share of a distant light that arrives at each point of a fog: what is not absorbed on the straight
/// path, plus an estimate of multiple scattering (octaves of [WKL13]). Stored on a lattice aligned with the
/// light, so that one pass of running sums computes it.
class LightField {
 public:
  /// `density`: not empty, any linear transform. `towards`: direction to the light, world, unit length.
  /// `extinction`: per world unit at density 1.
  LightField(const FloatGrid& density, const Vec3d& towards, double extinction);

  /// Share of the light at a world point, 0 to 1; outside the fog that of the nearest point of the lattice.
  float at(const Vec3d& world) const;

 private:
  Vec3d axes_[3];       // across, across, away from the light; unit length
  Vec3d origin_;        // of the lattice: the first node's coordinates along the axes
  double spacing_ = 1;  // world units
  openvdb::Coord size_;
  std::vector<float> light_;  // fastest along the light
};

}  // namespace slicemorph
