#pragma once

#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"

#include <optional>

namespace slicemorph {

/// Chart about an object's own curved axis.
struct FittedSpine {
  Chart chart;  ///< z0 in [-1, 1] from tip to tip, scale[0] half the axis' length, rotation-minimising frames
  double bow = 0;  ///< largest distance of the axis from its chord, in radii of the object
};

/// Finds the axis through the area centroids of the slices perpendicular to itself: starting from the
/// longest principal axis and from geodesic distances between the object's two ends, slices and refits
/// until it converges. Nothing where the object has no such axis: where it hardly extends further along
/// it than across, where slices would cross inside it, or where they would miss or count twice more
/// than 3 % of its volume.
std::optional<FittedSpine> fitSpine(const DistanceField& field);

}  // namespace slicemorph
