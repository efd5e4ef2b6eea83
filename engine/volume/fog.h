#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// A solid as a fog volume: 1 inside, falling to 0 at the surface across the inner half of the band.
FloatGrid::Ptr fogOf(const FloatGrid& levelSet);

}  // namespace slicemorph
