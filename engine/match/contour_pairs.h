#pragma once

#include "engine/match/base_warp.h"

namespace slicemorph {

/// The same surface point on every object.
struct Correspondence {
  std::vector<Vec3d> at;  ///< per object, its chart coordinates
  Vec3d middle{0, 0, 0};  ///< the point in the middle space
  float weight = 1;       ///< in the fit of a map
};

/// Two contours of the same slice that correspond: their objects, and their indices among
/// that slice's contours.
struct ContourPair {
  size_t slice, objectA, contourA, objectB, contourB;
  double overlap;  ///< intersection over union in the middle slice
};

/// Matches the contours of every object with those of the next one, slice by slice: the assignment of least
/// cost 1.2 * centroid distance + 0.35 * |log area ratio| in the middle slice, holes only with holes. A pair
/// is kept only where the two contours overlap there (intersection over union of at least 0.4): pairs
/// accepted without that test tear the surface where the number of contours changes from slice to slice.
std::vector<ContourPair> matchContours(const std::vector<ContourStack>& stacks, const BaseWarp& base);

/// Correspondences along the accepted pairs, `samples` points per contour; the second contour's first point
/// is the cyclic shift of best correlation.
std::vector<Correspondence> pairCorrespondences(const std::vector<ContourPair>& pairs,
                                                const std::vector<ContourStack>& stacks, const BaseWarp& base,
                                                int samples);

}  // namespace slicemorph
