#pragma once

#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"

#include <optional>

namespace slicemorph {

/// Chart about an object's own curved axis: z0 in [-1, 1] from tip to tip, scale[0] half the axis' length,
/// frames that do not spin. `bow`: how far the axis lies from its chord, in radii of the object.
struct FittedSpine {
  Chart chart;
  double bow = 0;
};

/// The axis through the area centroids of the slices perpendicular to itself: started from the geodesic
/// distances to the object's two ends, then sliced again until it rests. Nothing where the object has no such
/// axis: where it hardly spreads more along than across, where its slices would cross inside it, or miss or
/// count twice more than 3 % of its volume.
std::optional<FittedSpine> fitSpine(const DistanceField& field);

}  // namespace slicemorph
