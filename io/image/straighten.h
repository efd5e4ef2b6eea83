#pragma once

#include "io/image/raw_values.h"
#include "slicemorph/io/image_file.h"

namespace slicemorph {

/// Parallel slices of one size, each with its stored position.
struct SliceStackInput {
  Vec3d step[2];  ///< world vectors from a pixel to the next along a row, along a column
  int size[2] = {0, 0};
  std::vector<Vec3d> position;  ///< world position of each slice's first pixel, in order along the stack
  std::vector<std::string> names;
  std::vector<ImageValues> values;  ///< all of one type; freed as they are used
};

/// Puts a stack of slices on a lattice whose third axis is normal to them. Slices with even gaps and without
/// a shift in their plane are copied; else (tilted gantry, uneven gaps, missing slices) every voxel is
/// interpolated linearly between the slices at their stored positions, the outside gets the smallest value,
/// and `file.notes` says so. Throws InputError where the slices lie so far from each other that no lattice holds them, and
/// what `check` throws, which is asked where the lattice is another than that of the slices.
void straighten(SliceStackInput stack, const SizeCheck& check, ImageFile& file);

}  // namespace slicemorph
