#pragma once

#include "engine/frame/align.h"
#include "engine/match/contour_pairs.h"
#include "engine/spine/limbs.h"

namespace slicemorph {

/// A limb as the matching uses it.
struct PlacedLimb {
  std::vector<Vec3d> chart;    ///< its centre line from the body to the tip, chart coordinates of its object
  std::vector<Vec3d> middle;   ///< the same points in the middle space
  std::vector<double> radius;  ///< chart units
  double length = 0;           ///< in the middle space
};

/// Finds the limbs of every object and maps them to the middle space by `map`.
std::vector<std::vector<PlacedLimb>> placedLimbs(const Fields& fields, const std::vector<Chart>& charts,
                                                 const Displacements& map);

/// Corresponding limbs of all objects.
struct LimbGroup {
  std::vector<PlacedLimb> limb;  ///< per object
  bool grows = false;            ///< some objects lack it: there it is a stub below the surface
};

/// Matches limbs by where they leave the body, by their tips and their lengths; each object's limbs with the
/// means of the groups found so far. A limb without a partner becomes a short stub in the other objects,
/// wholly below the surface where it would be attached; it is left out where some object is too thin there to
/// hold a stub or its surface is too far away. `size`: of the objects, chart units.
std::vector<LimbGroup> groupLimbs(const std::vector<std::vector<PlacedLimb>>& limbs, const Fields& fields,
                                  const std::vector<Chart>& charts, const Displacements& map, double size);

/// Number of points that follow each one of a limb's centre line, around it.
constexpr size_t kPointsAround = 4;

/// Correspondences of one limb of all objects: points along its centre line, each followed by kPointsAround around it at
/// the limb's radius, in rotation-minimising frames. In the middle space the limb has the mean length, direction and
/// bending, so that it swings instead of moving along straight lines and becoming shorter.
std::vector<Correspondence> limbPoints(const std::vector<PlacedLimb>& limbs);

}  // namespace slicemorph
