#pragma once

#include "engine/sections/section_plane.h"

/// Plain oriented slices of any grid (for `slicemorph slice`); the morph's own slices live in chart space.
namespace slicemorph {

/// What a grid has at a slice's pixels: component by component, each width * height row by row.
struct SectionValues {
  int components = 1;  ///< 3 for vectors
  std::vector<float> values;
};

/// Samples one slice; thread-safe. Numbers and vectors are trilinear (staggered vectors face by face), whole
/// numbers and flags the nearest voxel's; all as the grid stores them: a signed distance, a density. Throws
/// InputError for grids that are not sliceable (see object_boxes.h), and for whole numbers beyond 2^24.
SectionValues sampleSection(const openvdb::GridBase& grid, const SectionPlane& plane);

/// The same of several slices, which is faster where they are near each other.
std::vector<SectionValues> sampleSections(const openvdb::GridBase& grid,
                                          const std::vector<SectionPlane>& planes);

}  // namespace slicemorph
