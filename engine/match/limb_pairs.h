#pragma once

#include "engine/match/contour_pairs.h"
#include "engine/spine/limbs.h"

namespace slicemorph {

/// A limb as the matching sees it.
struct PlacedLimb {
  std::vector<Vec3d> chart;   ///< its line, chart coordinates of its object
  std::vector<Vec3d> middle;  ///< the same places in the middle space
  std::vector<double> radius; ///< chart units
  double length = 0;          ///< in the middle space
};

/// Limbs matched by the places where they leave the body, their tips and their lengths; a limb without a partner stays
/// without. `size`: of the objects, middle space.
/// Returns per limb of the first object its partner among the second's; -1: none.
std::vector<int> matchLimbs(const std::vector<PlacedLimb>& a, const std::vector<PlacedLimb>& b, double size);

/// Points of a limb as every object has it, along the middle line and around it at the limb's radii, in frames that do not
/// spin. Half way the limb has the mean of their lengths and is bent and turned half as much as they are: it swings, and
/// does not cut across.
std::vector<Correspondence> limbPoints(const std::vector<PlacedLimb>& limbs);

}  // namespace slicemorph
