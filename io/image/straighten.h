#pragma once

#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Parallel slices of one size, each where it truly lies.
struct SliceStackInput {
  Vec3d step[2];  ///< world vectors from a pixel to the next along a row, along a column
  int size[2] = {0, 0};
  std::vector<Vec3d> position;  ///< of each slice's first pixel, in order along the stack
  std::vector<std::string> names;
  std::vector<ImageValues> values;  ///< all of one type; taken apart as they are used
};

/// Puts a stack of slices on a lattice with axes at right angles. Slices that lie evenly and straight above
/// each other are taken as they are; else (tilted gantry, uneven gaps, missing slices) every voxel is
/// interpolated linearly from where the slices truly lie, beyond them is the smallest value, and `file.notes`
/// says so.
void straighten(SliceStackInput stack, ImageFile& file);

}  // namespace slicemorph
