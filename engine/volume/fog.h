#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// A solid as fog volume: 1 inside, falling to 0 at the surface over the half width of its band.
FloatGrid::Ptr fogOf(const FloatGrid& levelSet);

}  // namespace slicemorph
