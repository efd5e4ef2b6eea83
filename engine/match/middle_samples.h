#pragma once

#include "engine/match/match_objects.h"
#include "engine/match/matching.h"

namespace slicemorph {

/// Samples of an object's surface, mapped to the middle space. Samples for which toMiddle does not converge
/// are left out.
struct MiddleSamples {
  OrientedPoints points;   ///< middle space
  std::vector<Vec3d> own;  ///< chart coordinates of the object
};

/// `points`: of the object, chart coordinates.
MiddleSamples middleSamples(const Matching& matching, size_t object, const OrientedPoints& points);

/// Samples of all objects' own surfaces. `count`: per object if there are two, see MatchObjects::ofEach.
std::vector<MiddleSamples> middleSamples(const MatchObjects& objects, const Matching& matching, int count);

}  // namespace slicemorph
