#pragma once

#include "engine/sections/section_plane.h"
#include "engine/spine/chart.h"

/// Planes for `slicemorph slice`, through all given grids at once: they cover a level set's inside, else the
/// active voxels, with a margin of three pixels within the plane. Pixels are `pixelSize` world units wide; 0:
/// the smallest voxel size of the grids. All functions throw GeometryError if the grids are empty, and
/// InputError for frustum transforms, options out of range and slices of more than 2^28 pixels.
namespace slicemorph {

struct SectionOptions {
  Vec3d axis{0, 0, 0};  ///< slicing direction, world, any length; zero: the object's principal axis
  int count = 64;       ///< number of slices, 1 to 100000
  double pixelSize = 0;
};

/// Parallel planes at the centres of slabs of equal thickness, from end to end; all of the same size.
std::vector<SectionPlane> sectionPlanes(const openvdb::GridCPtrVec& grids,
                                        const SectionOptions& options = {});

/// Planes perpendicular to a spine, hence in general oblique to each other, at the centres of sections of
/// equal length along it; all of the same size.
std::vector<SectionPlane> sectionPlanesAlong(const Chart& spine, const openvdb::GridCPtrVec& grids, int count,
                                             double pixelSize = 0);

struct PlaneInSpace {
  Vec3d origin{0, 0, 0};  ///< a pixel's centre is here, or would be if the pixel grid were continued
  Vec3d normal{0, 0, 1};  ///< any length but zero
};

/// Given planes, each as large as its intersection with the object. Throws InputError for a plane that does
/// not intersect it.
std::vector<SectionPlane> sectionPlanesAt(const std::vector<PlaneInSpace>& given,
                                          const openvdb::GridCPtrVec& grids, double pixelSize = 0);

}  // namespace slicemorph
