#pragma once

#include "engine/frame/align.h"
#include "engine/match/contour_pairs.h"
#include "engine/spine/limbs.h"

namespace slicemorph {

/// A limb as the matching sees it.
struct PlacedLimb {
  std::vector<Vec3d> chart;    ///< its line, chart coordinates of its object
  std::vector<Vec3d> middle;   ///< the same places in the middle space
  std::vector<double> radius;  ///< chart units
  double length = 0;           ///< in the middle space
};

/// The limbs of every object, by the map so far.
std::vector<std::vector<PlacedLimb>> placedLimbs(const Fields& fields, const std::vector<Chart>& charts,
                                                 const Displacements& map);

/// One limb as every object has it.
struct LimbGroup {
  std::vector<PlacedLimb> limb;  ///< per object
  bool grows = false;            ///< some objects lack it: there it is a stub below the surface
};

/// Limbs matched, object after object with those that the ones before have in common, by the places where
/// they leave the body, their tips and their lengths. One without a partner lies in the other objects as a
/// short stub, wholly below the surface where it would be attached; it is left out where there is no body to
/// take it. `size`: of the objects, middle space.
std::vector<LimbGroup> groupLimbs(const std::vector<std::vector<PlacedLimb>>& limbs, const Fields& fields,
                                  const std::vector<Chart>& charts, const Displacements& map, double size);

/// Points of a limb as every object has it, along the middle line and around it at the limb's radii, in
/// frames that do not spin. Half way the limb has the mean of their lengths and is bent and turned half as
/// much as they are: it swings, and does not cut across.
std::vector<Correspondence> limbPoints(const std::vector<PlacedLimb>& limbs);

}  // namespace slicemorph
