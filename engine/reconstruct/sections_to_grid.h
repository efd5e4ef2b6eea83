#pragma once

#include "engine/sections/section.h"

namespace slicemorph {

/// Slices of one grid, to be put together again.
struct SlicedGrid {
  /// Without voxels: type, class, name, background, metadata of what is made.
  openvdb::GridBase::ConstPtr prototype;
  std::vector<SectionValues> slices;  ///< one per plane
};

/// Planes in the order in which they follow each other: parallel ones by place, others as they are.
/// Throws InputError for fewer than two, and for two in a row that stand across each other.
std::vector<size_t> orderOfSections(const std::vector<SectionPlane>& planes);

/// The grid on voxels of `voxelSize` world units, parallel to the world's axes: between two slices linear
/// along the line that stands evenly on both, in them bilinear (whole numbers and flags: the nearest pixel of
/// the nearer slice), so that what is linear in space comes back as it was. Slices may lean; where several
/// pairs hold a place, the one whose images have it nearest to their middle counts. Beyond the first and the
/// last slice values hold for half the gap. `planes`: in their order. Distances are taken along Catmull-Rom
/// splines, in the slices and, where these are parallel and as far apart, across four of them; level sets are
/// made distances again in a band of three voxels; where they would reach too little they throw InputError
/// naming the voxel size that they serve. Throws InputError for too many voxels.
openvdb::GridBase::Ptr gridOfSections(const std::vector<SectionPlane>& planes, const SlicedGrid& sliced,
                                      double voxelSize);

/// The largest voxel size at which slices of this grid make a level set, world units; infinite of other
/// grids.
double mostVoxelSize(const openvdb::GridBase& prototype);

}  // namespace slicemorph
