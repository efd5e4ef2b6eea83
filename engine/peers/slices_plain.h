#pragma once

#include "engine/peers/outline_stack.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

struct PlainSlicesOptions {
  int slices = 96;    ///< per object, 2 or more
  int samples = 128;  ///< points per contour, 8 or more
};

/// The slice method as published [YT09], without what this program adds to it: each object is cut into equally many
/// parallel slices across the longest axis of its oriented bounding box; the contours of a slice become clouds of points
/// that are matched by rays at equal angles from their centroids, or, where a contour meets a ray more than once, by
/// their order from the angle 0 on; matched points move along straight lines, and the surface is rebuilt from the
/// slices. Boxes turn into each other by the shorter way.
class PlainSlices {
 public:
  /// `voxelSize`: world units. Throws InputError for options out of range and where slices have too many pixels.
  PlainSlices(const std::vector<Object>& objects, double voxelSize, const PlainSlicesOptions& options = {});
  /// A level set named "surface". Throws InputError unless there is one weight per object.
  FloatGrid::Ptr frame(const Weights& weights) const;

 private:
  struct Box {
    Chart chart;
    double low = 0, high = 0;
  };
  std::vector<Box> boxes_;
  /// Per slice, contour and object: matched points.
  std::vector<std::vector<std::vector<std::vector<Vec2d>>>> slices_;
  double voxelSize_ = 0;
};

}  // namespace slicemorph
