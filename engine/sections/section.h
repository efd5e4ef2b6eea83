#pragma once

#include "engine/sections/section_plane.h"

/// Plane oriented slices of any grid, for `slicemorph slice`. The morph's own slices are in chart space.
namespace slicemorph {

/// A grid's values at a slice's pixels: component by component, each width * height long, row by row.
struct SectionValues {
  int components = 1;  ///< 3 for vectors
  std::vector<float> values;
};

/// Samples one slice; thread-safe. Numbers and vectors are trilinear (staggered vectors component by
/// component on their faces), integers and flags take the nearest voxel; values are as stored in the grid (a
/// signed distance, a density). Throws InputError for grids that cannot be sliced (see object_boxes.h), and
/// for integers beyond 2^24.
SectionValues sampleSection(const openvdb::GridBase& grid, const SectionPlane& plane);

/// The same for several slices, which is faster if they are close to each other.
std::vector<SectionValues> sampleSections(const openvdb::GridBase& grid,
                                          const std::vector<SectionPlane>& planes);

}  // namespace slicemorph
