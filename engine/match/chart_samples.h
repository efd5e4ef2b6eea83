#pragma once

#include "engine/match/soft_match.h"
#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"

namespace slicemorph {

/// Samples spread evenly over one surface of an object, in chart coordinates.
struct ChartSamples {
  OrientedPoints points;
  double area = 0;  ///< of the whole surface, chart units squared
};

ChartSamples chartSamples(const DistanceField& field, const Chart& chart);

/// About `count` of the samples, one of every bin, so that a sample more or less in one spot does not change
/// the choice everywhere else. `origin`: where the bins begin, chart coordinates.
OrientedPoints thinned(const ChartSamples& samples, int count, const Vec3d& origin);

}  // namespace slicemorph
