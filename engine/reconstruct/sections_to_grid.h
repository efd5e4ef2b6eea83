#pragma once

#include "engine/sections/section.h"

namespace slicemorph {

/// Slices of one grid, to be assembled.
struct SlicedGrid {
  /// Has no voxels; gives the result's type, class, name, background and metadata.
  openvdb::GridBase::ConstPtr prototype;
  std::vector<SectionValues> slices;  ///< one per plane
};

/// The order in which planes follow each other: parallel ones by position, others as numbered. Checks
/// nothing: the constructor of SectionSlabs throws for planes that cannot be used.
std::vector<size_t> orderOfSections(const std::vector<SectionPlane>& planes);

/// The grid on voxels of `voxelSize` world units, parallel to the world's axes. Linear between two slices,
/// along the direction that bisects their normals, and bilinear within them, so that functions linear in
/// space are reproduced; integers and flags take the nearest pixel of the nearer slice. Slices may be oblique
/// to each other; where several pairs contain a position, the pair whose images have it nearest to their
/// centres is used. Beyond the first and last slice values extend for half a gap. `planes`: in order.
/// Distances use Catmull-Rom splines within the slices and, if these are parallel and evenly spaced, across
/// four of them; level sets are redistanced in a band of three voxels. Throws InputError if the slices'
/// distances reach less far than that, naming the largest possible voxel size, and for too many voxels.
openvdb::GridBase::Ptr gridOfSections(const std::vector<SectionPlane>& planes, const SlicedGrid& sliced,
                                      double voxelSize);

/// The largest voxel size, in world units, at which slices of this grid make a level set; infinite
/// for other grids.
double mostVoxelSize(const openvdb::GridBase& prototype);

}  // namespace slicemorph
