#pragma once

#include "engine/volume/distance_field.h"

namespace slicemorph {

/// A branch of a body (leg, arm, tail, neck): its middle line from where it leaves the body to its tip.
struct Limb {
  std::vector<Vec3d> line;     ///< world; Limb::kSections points, the last one the tip
  std::vector<double> radius;  ///< world units, at each
  double length = 0;           ///< world units
  static constexpr int kSections = 13;
};

/// The branches of an object: parts of the inside that run out to a tip of their own, by geodesic distance
/// from the body's deepest place. A branch counts that is longer than its width, thinner than the body and
/// not much shorter than the longest way.
std::vector<Limb> findLimbs(const DistanceField& field);

}  // namespace slicemorph
