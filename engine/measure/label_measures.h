#pragma once

#include "slicemorph/image.h"

namespace slicemorph {

/// Measures of one label of a map; world units.
struct LabelMeasures {
  std::int64_t label = 0;
  size_t voxels = 0;
  double volume = 0;
  double area = 0;          ///< by Crofton's formula over 13 directions [OS09], within some per cent
  Vec3d extents{0, 0, 0};   ///< of its bounding box along the image's own axes
  Vec3d centroid{0, 0, 0};  ///< world
};

/// Measures all labels of a map except 0, ascending.
std::vector<LabelMeasures> measureLabels(const Image& labels);

/// The same for the part of a grey image above `iso`, as label 1.
LabelMeasures measureAbove(const Image& image, double iso);

}  // namespace slicemorph
