#pragma once

#include "engine/spine/chart.h"
#include "engine/volume/distance_field.h"

#include <openvdb/math/Vec2.h>

namespace slicemorph {

using openvdb::Vec2d;

/// The slice planes and pixel grid in chart space, shared by all objects.
struct SlicePlanes {
  std::vector<double> z0;  ///< position of each plane along the spine, chart units
  Vec2d origin{0, 0};      ///< of pixel (0, 0), chart units
  double pixel = 0;        ///< chart units
  int nx = 0, ny = 0;
};

/// Signed distances on one slice, chart units, row by row (index y * nx + x).
using SliceImage = std::vector<float>;

/// `count` planes through the middles of equal slabs of the box that holds all objects in chart space. `finest`: no pixel
/// is smaller, chart units.
SlicePlanes placeSlices(const std::vector<openvdb::BBoxd>& chartBoxes, int count, double finest = 0);

/// Samples the signed distance on every slice of one object.
std::vector<SliceImage> sampleSlices(const DistanceField& field, const Chart& chart,
                                     const SlicePlanes& planes);

}  // namespace slicemorph
