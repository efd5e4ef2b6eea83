#pragma once

#include "engine/sections/section_plane.h"
#include "io/exr/exr_slice.h"

#include <ImfHeader.h>

namespace slicemorph {

/// Adds the attributes of a slice's position (see io/exr/exr_slice.h).
void placeSlice(Imf::Header& header, const SectionPlane& plane);

/// Adds the attributes of a grid.
void describeGrid(Imf::Header& header, const SliceGrid& slice);

}  // namespace slicemorph
