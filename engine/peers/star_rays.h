#pragma once

#include "engine/volume/distance_field.h"

#include <functional>

namespace slicemorph {

/// Where a ray from a point inside a shape meets its surface.
struct RayHit {
  double distance = 0;  ///< of the first crossing from the start, world units
  bool single = true;   ///< whether the ray leaves the shape once and for all there
};

/// Follows a ray, `direction` of length 1, until it is out of the shape's box. What comes and goes within half a voxel is
/// not seen. `counts`: whether what lies at a point belongs to the ray's own part of the shape; empty: it always does.
RayHit followRay(const DistanceField& field, const DistanceField::Sampler& sample, const Vec3d& from,
                 const Vec3d& direction, const std::function<bool(const Vec3d&)>& counts = {});

/// A point that sees the whole surface, as far as about 8,000 samples of it tell: the centroid of the inside; where that
/// does not see it all a point found by steps to the side of the tangent planes that it is behind (relaxation for linear
/// inequalities [Agm54]), or, if none is found, the last one tried.
Vec3d starCentre(const DistanceField& field);

}  // namespace slicemorph
