#pragma once

#include "engine/match/base_warp.h"
#include "engine/match/match_objects.h"

namespace slicemorph {

/// The slices of every object, equal in number: slice i of one object corresponds to slice i of the others.
struct SlicedObjects {
  SlicePlanes planes;                           ///< of the middle slices
  std::vector<std::vector<double>> position;    ///< per object and slice: z0 of its own, chart units, rising
  std::vector<std::vector<SliceImage>> images;  ///< per object and slice
  Notes notes;
};

/// Cuts every object into `count` slices, at positions along its spine that correspond (`matchAlongSpine`).
SlicedObjects sliceObjects(const MatchObjects& objects, int count);

/// The same, at equal chart positions for all objects.
SlicedObjects sliceAtEqualPositions(const MatchObjects& objects, int count);

/// The contours on the slices of every object.
struct TracedObjects {
  SlicePlanes planes;                         ///< as in SlicedObjects
  std::vector<std::vector<double>> position;  ///< as in SlicedObjects
  std::vector<ContourStack> stacks;           ///< per object
  Notes notes;                                ///< of slicing and tracing
};

/// Traces the contours on all slices.
TracedObjects traceObjects(SlicedObjects slices);

}  // namespace slicemorph
