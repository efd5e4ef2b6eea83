#pragma once

#include "engine/match/middle_samples.h"

#include <functional>

namespace slicemorph {

/// A point projected onto another object.
struct Projected {
  Vec3d at;     ///< chart coordinates; the unprojected point where trust is 0
  float trust;  ///< 0 to 1
};

/// Trust in a point at a distance from where it was: 1 up to three quarters of the reach, 0 from the reach on.
double trustAt(double distance, double reach);

/// Correspondences from one object's samples to their projections onto the other objects, weighted by the most trusted
/// of these; samples without any are left out. `object`: whose samples they are; `project(k, before, i)`: sample i, which the
/// map carries to `before` on object k, projected onto it; called from several threads.
std::vector<Correspondence> meetingPoints(
    size_t object, size_t objects, const Displacements& map, const MiddleSamples& samples,
    const std::function<Projected(size_t k, const Vec3d& before, size_t i)>& project);

}  // namespace slicemorph
