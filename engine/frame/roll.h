#pragma once

#include "engine/frame/align.h"

namespace slicemorph {

/// Rotation of one object's slices within their planes that lays them on another object's.
struct Roll {
  double steady = 0;  ///< one angle for all slices, radians
  double steadyOverlap =
      0;  ///< mean intersection over union of the slices so turned, each about its centroid
  std::vector<double> along;  ///< angles that vary along the spine, at Bend's stations, radians
  double alongOverlap = 0;    ///< mean intersection over union with these
};

/// Finds the roll from a's slices to b's, by comparing slices in polar coordinates and, for varying angles,
/// dynamic programming along the spine. Both charts reach from z0 = -half to half. `preferred`: the angle to
/// take where all are equally good, as on round slices, radians.
Roll findRoll(const DistanceField& a, const Chart& chartA, const DistanceField& b, const Chart& chartB,
              double half, double preferred);

/// The chart with its slices turned in their planes by the angles at its stations.
Chart twisted(const Chart& chart, double half, const std::vector<double>& angles);

}  // namespace slicemorph
