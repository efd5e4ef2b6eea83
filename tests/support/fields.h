#pragma once

#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"
#include "tests/support/shapes.h"

#include <memory>

namespace slicemorph::shapes {

/// Distances to a shape inside `box` (world), from its level set with voxel size `h`.
inline std::shared_ptr<const DistanceField> fieldOf(const Distance& shape, const openvdb::BBoxd& box,
                                                    double h) {
  return std::make_shared<DistanceField>(levelSet(shape, box, h));
}

/// A straight chart along the world's axes with `scale` world units per chart unit.
inline Chart straightChart(const Vec3d& center = Vec3d(0.0), double scale = 1) {
  Chart chart;
  chart.center = center, chart.scale = Vec3d(scale);
  return chart;
}

}  // namespace slicemorph::shapes
