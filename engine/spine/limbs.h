#pragma once

#include "engine/volume/distance_field.h"

namespace slicemorph {

/// A branch of a body (leg, arm, tail, neck): its centre line from where it leaves the body to its tip.
struct Limb {
  std::vector<Vec3d> line;     ///< world; kSections points, the last one the tip
  std::vector<double> radius;  ///< per point, world units
  double length = 0;           ///< world units
  static constexpr int kSections = 13;
};

/// Finds the branches of an object: parts of the inside with a tip of their own, that is a local maximum of
/// the geodesic distance from the body's deepest point. A branch counts if it is longer than wide, thinner
/// than the body and sticks out by more than 12 % of the longest path. One that is hardly longer than wide and ends in
/// several thin ones, as a head with horns, ends where these start.
std::vector<Limb> findLimbs(const DistanceField& field);

}  // namespace slicemorph
