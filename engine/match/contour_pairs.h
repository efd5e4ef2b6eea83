#pragma once

#include "engine/match/base_warp.h"

namespace slicemorph {

/// The same surface point on every object, chart coordinates of each.
struct Correspondence {
  std::vector<Vec3d> at;  ///< per object
  Vec3d middle{0, 0, 0};  ///< where it is half way between all objects
  float weight = 1;
};

/// Partner of a contour among another object's contours of the same slice; -1: none is trusted.
struct ContourPair {
  size_t slice, objectA, contourA, objectB, contourB;
  double overlap;  ///< intersection over union in the middle slice
};

/// Matches the contours of every object with those of the next one, slice by slice and one slice a task: the
/// assignment of least cost 1.2 centroid distance + 0.35 |log area ratio| in the middle slice, holes only
/// with holes; a pair is kept only where the two contours overlap there (intersection over union of at least
/// 0.4), for pairs taken on faith tear the surface where the number of contours changes from slice to slice.
std::vector<ContourPair> matchContours(const std::vector<ContourStack>& stacks, const BaseWarp& base);

/// Points of the accepted pairs, `samples` along each contour, joined at the cyclic start of best
/// correlation.
std::vector<Correspondence> pairCorrespondences(const std::vector<ContourPair>& pairs,
                                                const std::vector<ContourStack>& stacks, const BaseWarp& base,
                                                int samples);

}  // namespace slicemorph
