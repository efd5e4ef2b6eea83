#pragma once

#include "engine/conventions.h"

/// Plain oriented slices of any float grid (for `slicemorph slice`); the morph's own slices live in chart
/// space.
namespace slicemorph {

struct SectionOptions {
  Vec3d axis{0, 0, 0};   ///< slicing direction, world, any length; zero: the principal axis of the object
  int count = 64;        ///< slices, 1 to 100000
  double pixelSize = 0;  ///< world units; 0: the grid's smallest voxel size
};

/// Where a slice lies in the world: the centre of pixel (i, j), i to the right and j downwards in the image,
/// is at origin + pixelSize * (i * xAxis + j * yAxis). The axes are orthonormal and right-handed: normal =
/// xAxis x yAxis.
struct SectionPlane {
  int index = 0;  ///< 0 to count - 1
  int count = 0;
  double u = 0;  ///< -1 to 1 along the object; slices lie in the middle of slabs of equal thickness
  Vec3d origin{0, 0, 0};
  Vec3d xAxis{1, 0, 0};
  Vec3d yAxis{0, 1, 0};
  Vec3d normal{0, 0, 1};
  double pixelSize = 1;
  int width = 0;  ///< pixels, the same for all slices
  int height = 0;
};

struct Section {
  SectionPlane plane;
  std::vector<float>
      values;  ///< width * height, row by row, trilinear; what the grid stores: a signed distance, a density
};

/// The planes that cut the object (a level set's inside, else the active voxels) from end to end, with a
/// margin of three pixels in the plane. Throws GeometryError for an empty grid, InputError for options out of
/// range or slices of more than 2^28 pixels.
std::vector<SectionPlane> sectionPlanes(const FloatGrid& grid, const SectionOptions& options = {});

/// One slice; thread-safe. A caller that writes slices one by one need not hold them all.
Section sampleSection(const FloatGrid& grid, const SectionPlane& plane);

/// All slices, one task each.
std::vector<Section> sections(const FloatGrid& grid, const SectionOptions& options = {});

}  // namespace slicemorph
