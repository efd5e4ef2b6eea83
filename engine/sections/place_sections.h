#pragma once

#include "engine/sections/section_plane.h"
#include "engine/spine/chart.h"

/// Planes for `slicemorph slice`, through all of several grids at once: a level set's inside, else the active
/// voxels, with a margin of three pixels in the plane. Pixels are `pixelSize` world units wide; 0: the
/// smallest voxel size of the grids. All throw GeometryError where the grids are empty, InputError for
/// frustum transforms, options out of range and slices of more than 2^28 pixels.
namespace slicemorph {

struct SectionOptions {
  Vec3d axis{0, 0, 0};  ///< slicing direction, world, any length; zero: the principal axis of the object
  int count = 64;       ///< slices, 1 to 100000
  double pixelSize = 0;
};

/// Parallel planes in the middles of slabs of equal thickness, from end to end; all of one size.
std::vector<SectionPlane> sectionPlanes(const openvdb::GridCPtrVec& grids,
                                        const SectionOptions& options = {});

/// Leaning planes across a spine, in the middles of slabs of equal length along it; all of one size.
std::vector<SectionPlane> sectionPlanesAlong(const Chart& spine, const openvdb::GridCPtrVec& grids, int count,
                                             double pixelSize = 0);

struct PlaneInSpace {
  Vec3d origin{0, 0, 0};  ///< a pixel's centre is here, or whole pixels from here
  Vec3d normal{0, 0, 1};  ///< any length but zero
};

/// Given planes, each as large as what it cuts. Throws InputError for a plane that cuts nothing.
std::vector<SectionPlane> sectionPlanesAt(const std::vector<PlaneInSpace>& given,
                                          const openvdb::GridCPtrVec& grids, double pixelSize = 0);

}  // namespace slicemorph
