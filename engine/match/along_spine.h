#pragma once

#include "engine/frame/align.h"
#include "engine/match/base_warp.h"

namespace slicemorph {

/// Which slices of the objects correspond: the slices of a head to those of the other head, even where the
/// necks differ in length.
struct AlongSpine {
  std::vector<std::vector<double>>
      position;  ///< per object and middle slice: z0 of the object's slice, chart units, rising
  double before = 1,
         after = 1;  ///< mean overlap of slices at equal positions, and of corresponding slices
};

/// Matches each object's slices with the first object's by dynamic programming: maximal overlap of the
/// slices, after each object as a whole is scaled to the same thickness, minus a price for shifting and
/// stretching. A slice moves by at most a third of the objects' common length. The shifts are scaled by a
/// smoothstep of the overlap's gain and one of the overlap itself: positions stay equal where matching gains
/// too little, or where the matched slices still overlap too little.
AlongSpine matchAlongSpine(const Fields& fields, const std::vector<Chart>& charts, const SlicePlanes& planes);

}  // namespace slicemorph
