#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// A slice of a map across one of its axes.
struct CrossSlice {
  int axis = 2, at = 0;
};

/// The slices that one label was drawn on, ascending by axis and number.
struct CrossLabel {
  int label = 0;
  std::vector<CrossSlice> slices;
};

/// Labels drawn on slices across two or three axes of one map, lines of the ones crossing the areas of the others:
/// where most voxels lie in thin sheets along such slices. Empty where that is not so: all slices are across one
/// axis, or the map is dense.
std::vector<CrossLabel> findCrossSlices(const Image& labels);

/// The outlines of a label on its slices, world space.
ContourSet outlinesOf(const Image& labels, const CrossLabel& label);

/// The map with labels between their slices, the given voxels as they were. A slice tells where its label is not.
/// `between`: per voxel 0, or 1 + the number in `cross` of the label that is there.
Image withGiven(const Image& labels, const std::vector<CrossLabel>& cross, const Image& between);

}  // namespace slicemorph
