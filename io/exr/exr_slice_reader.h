#pragma once

#include "engine/reconstruct/sections_to_grid.h"
#include "slicemorph/io/input_spec.h"
#include "slicemorph/io/memory.h"
#include "slicemorph/note.h"

#include <string>

namespace slicemorph {

/// Slices in their order along the set.
struct ExrSlices {
  std::vector<SectionPlane> planes;
  std::vector<SlicedGrid> grids;
  Notes notes;  ///< slices that are missing, one sentence each
};

/// Reads EXR slices of the layout of io/exr/exr_slice.h: float or half, tiled or not, whole or cropped.
/// `wanted`: only these grids; empty: all. Throws IoError naming a file that is missing, damaged, without an
/// attribute or a channel, or of another set than the first; InputError for an unknown grid, listing those
/// of the file; MemoryError where their pixels would not fit, before these are read.
ExrSlices readSliceExrs(const InputSpec& input, const std::vector<std::string>& wanted = {},
                        const MemoryLimit& memory = {});

}  // namespace slicemorph
