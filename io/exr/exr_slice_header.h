#pragma once

#include "engine/sections/section_plane.h"
#include "io/exr/exr_slice.h"

#include <ImfHeader.h>

namespace slicemorph {

/// The attributes that say where a slice lies, as io/exr/exr_slice.h lays them down.
void placeSlice(Imf::Header& header, const SectionPlane& plane);

/// The attributes of a grid.
void describeGrid(Imf::Header& header, const SliceGrid& slice);

}  // namespace slicemorph
