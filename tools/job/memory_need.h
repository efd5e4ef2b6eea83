#pragma once

#include "engine/render/film.h"
#include "engine/sections/section_plane.h"
#include "slicemorph/image.h"
#include "slicemorph/io/input.h"

#include <string>
#include <vector>

/// What the parts of a job take, estimated before they take it. All figures are lower bounds, measured on the program
/// itself (see memory_need.cpp): what is refused cannot fit, and what nearly fits may still end in std::bad_alloc,
/// which ends with a message, too.
namespace slicemorph {

struct MemoryNeed {
  double bytes = 0;    ///< beside what is taken already
  std::string what;    ///< that needs it, as "matching 4.2 million voxels"
  std::string advice;  ///< what to change
};

/// Throws MemoryError where less is left. `about`: the file or option.
void require(const MemoryLimit& limit, const std::string& about, const MemoryNeed& need);

/// The plan of a morph between loaded inputs, and its frames, one after another.
MemoryNeed needOfMorph(const std::vector<LoadedObject>& inputs);

/// Distances and overlap of two shapes.
MemoryNeed needOfComparison(const FloatGrid& a, const FloatGrid& b);

/// An image of so many bytes a voxel.
MemoryNeed needOfImage(const ImageLattice& lattice, double bytesPerVoxel);

/// A grid's active box as an image.
MemoryNeed needOfDenseGrid(const openvdb::GridBase& grid);

/// One picture while it is made and written.
MemoryNeed needOfPicture(const RenderOptions& options);

/// Slices of grids with so many numbers a pixel, one at a time, while they are written.
MemoryNeed needOfSlices(const std::vector<SectionPlane>& planes, size_t channels);

}  // namespace slicemorph
