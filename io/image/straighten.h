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

/// How a stack is put on a lattice.
struct Straightening {
  std::vector<double> along;          ///< of each slice from the first along the normal, millimetres
  std::vector<openvdb::Vec2d> shift;  ///< of each in its plane, pixels
  double gap = 1;                     ///< millimetres
  bool copied = false;                ///< slices become the lattice's as they are
  openvdb::Vec2i first{0, 0};         ///< pixel of the first slice at which the lattice begins
};
/// Sets the lattice of a stack, whose values are not looked at, with the notes of straighten(). Throws InputError as that.
Straightening layOut(const SliceStackInput& stack, ImageFile& file);

/// Puts a stack of slices on a lattice whose third axis is normal to them. Slices with even gaps and without
/// a shift in their plane are copied; else (tilted gantry, uneven gaps, missing slices) every voxel is
/// interpolated linearly between the slices at their stored positions, the outside gets the smallest value,
/// and `file.notes` says so. Throws InputError where the slices lie so far from each other that no lattice holds them, and
/// what `check` throws, which is asked where the lattice is another than that of the slices.
void straighten(SliceStackInput stack, const SizeCheck& check, ImageFile& file);

}  // namespace slicemorph
