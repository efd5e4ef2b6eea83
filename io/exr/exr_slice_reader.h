#pragma once

#include "engine/reconstruct/sections_to_grid.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/note.h"

#include <string>

namespace slicemorph {

/// Slices as their files place them, in the order in which they follow each other.
struct ExrSlices {
  std::vector<SectionPlane> planes;
  std::vector<SlicedGrid> grids;
  Notes notes;  ///< slices that are missing, one sentence each
};

/// Reads EXR slices as io/exr/exr_slice.h says, float or half, tiled or not, whole or cropped. `wanted`: only
/// these grids; empty: all. Throws IoError naming the file: missing, damaged, without an attribute or a
/// channel, of another set than the first; InputError for a grid that is not there, listing those that are.
ExrSlices readSliceExrs(const InputSpec& input, const std::vector<std::string>& wanted = {});

}  // namespace slicemorph
