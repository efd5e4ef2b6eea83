#pragma once

#include "engine/reconstruct/contour_surface.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// Which object gets a voxel that is inside several objects.
enum class SharedVoxel {
  /// The object of smallest volume: for regions that may be nested, such as organs in the body (DICOM RT).
  smallest,
  /// The object whose surface is farthest away: for materials that touch and share a wall (CSL).
  deepest
};

/// The label of the object at each voxel's centre, 0 outside all objects; 8 bit if the labels fit, else 16
/// bit. Depths are compared up to the width of the narrower of two bands; ties go to the smaller volume, then
/// to the object whose centroid comes first along x, y, z, so that label numbers have no influence. Throws
/// InputError unless there is one label in 1..65535 per surface, and for an empty lattice.
Image contourLabels(const std::vector<ContourSurface>& surfaces, const std::vector<int>& labels,
                    const ImageLattice& on, SharedVoxel rule);

/// The same, and by surface the voxels inside it and those of them that hold its label.
struct ContourMap {
  Image image;
  std::vector<size_t> own, shown;
};
ContourMap contourMap(const std::vector<ContourSurface>& surfaces, const std::vector<int>& labels,
                      const ImageLattice& on, SharedVoxel rule);

/// The voxels that a mask covers.
enum class MaskOf {
  all,    ///< the whole lattice
  itsBox  ///< the voxels of the lattice around the object alone, for measures
};

/// 1 at each voxel whose centre is inside the object, else 0; 8 bit.
Image contourMask(const ContourSurface& surface, const ImageLattice& on, MaskOf extent);

/// A lattice around all contours, with a margin of two voxels, plus three quarters of a gap across parallel
/// planes. If the planes are parallel, its slices coincide with them (the spacing across them divides the
/// usual gap and is at most `voxelSize`, world units); otherwise its axes are the world's. Throws
/// GeometryError without contours; InputError if the voxel size is not positive or the lattice would have
/// more than 2e9 voxels.
ImageLattice contourLattice(const std::vector<ContourSet>& sets, double voxelSize);

}  // namespace slicemorph
