#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// How one object's slices must be turned in their planes to lie on another's, slice by slice.
struct Roll {
  double steady = 0;  ///< radians; one angle for all slices
  double steadyOverlap =
      0;  ///< mean intersection over union of the slices so turned, each about its own middle
  std::vector<double> along;  ///< radians at Bend's stations: an angle of its own for each slice
  double alongOverlap = 0;
};

/// From a's slices to b's, by correlation of the slices in polar coordinates (dynamic programming along the
/// spine). Both charts reach from z0 = -half to half. `preferred`: the angle that wins where all are equal,
/// as on round slices.
Roll findRoll(const DistanceField& a, const Chart& chartA, const DistanceField& b, const Chart& chartB,
              double half, double preferred);

/// The chart with its slices turned in their planes by the angles at its stations.
Chart twisted(const Chart& chart, double half, const std::vector<double>& angles);

}  // namespace slicemorph
