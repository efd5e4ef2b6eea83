#pragma once

#include "engine/reconstruct/contour_surface.h"
#include "slicemorph/image.h"

namespace slicemorph {

/// Who gets a voxel that lies inside several objects.
enum class SharedVoxel {
  smallest,  ///< the object of smallest volume: regions that may lie in each other, as organs in the body
             ///< (DICOM RT)
  deepest    ///< the one whose surface is farthest away: materials that touch and share a wall (CSL)
};

/// The label of each voxel's centre, 0 outside all objects: 8 bit where the labels fit, else 16. Depths are
/// compared as far as the narrower of two bands goes; what is equal then goes to the smaller volume, then to
/// the object whose middle comes first along x, y, z: label numbers play no part. Throws InputError where
/// labels are not one a surface and in 1..65535, or the lattice is empty.
Image contourLabels(const std::vector<ContourSurface>& surfaces, const std::vector<int>& labels,
                    const ImageLattice& on, SharedVoxel rule);

/// A lattice around all contours with two voxels and three quarters of a gap to spare. For parallel planes
/// its slices lie on the planes (the spacing across them divides the usual gap and is at most `voxelSize`,
/// world units), else its axes are the world's. Throws GeometryError without contours; InputError where the
/// voxel size is not positive or the lattice would be absurdly large.
ImageLattice contourLattice(const std::vector<ContourSet>& sets, double voxelSize);

}  // namespace slicemorph
