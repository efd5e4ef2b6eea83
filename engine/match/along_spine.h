#pragma once

#include "engine/frame/align.h"
#include "engine/match/base_warp.h"

namespace slicemorph {

/// Which slices of the objects belong together, a head's with a head's though necks differ in length.
struct AlongSpine {
  std::vector<std::vector<double>>
      place;  ///< per object and middle slice: z0 of the object's slice, chart units, rising
  double before = 1,
         after = 1;  ///< mean overlap of slices at equal places, and of those that belong together
};

/// Finds them by dynamic programming against the first object: the greatest overlap of the slices, made
/// equally thick as wholes, less a price for stretching; every slice moves by at most a sixth of the way. The
/// places are taken to the degree to which the overlap gains and is great: equal places where it does not
/// gain, or where the slices are not alike anyhow.
AlongSpine matchAlongSpine(const Fields& fields, const std::vector<Chart>& charts, const SlicePlanes& planes);

}  // namespace slicemorph
