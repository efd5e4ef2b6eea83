#pragma once

#include "engine/match/soft_match.h"
#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"

namespace slicemorph {

/// The samples of one surface of an object, in chart coordinates.
struct ChartSamples {
  OrientedPoints points;
  double area = 0;  ///< of the whole surface, chart units squared
};

ChartSamples chartSamples(const DistanceField& field, const Chart& chart);

/// About `count` of the samples, one per bin, so that a sample more or less in one spot does not change the
/// choice elsewhere. `origin`: corner of the grid of bins, chart coordinates.
OrientedPoints thinned(const ChartSamples& samples, int count, const Vec3d& origin);

}  // namespace slicemorph
