#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/mesh.h"
#include "slicemorph/note.h"
#include "slicemorph/progress.h"

namespace slicemorph {

struct ContourSurfaceOptions {
  double voxelSize = 0;  ///< world units; 0: chosen by contourVoxelSize
  /// A parallel next plane more than this many usual gaps away says nothing about the space in between: the object is
  /// closed on both sides.
  double bridgedGaps = 3;
  double mostNodes = 4e7;  ///< of the lattice at the default voxel size; each takes about 16 bytes
};

struct ContourSurface {
  FloatGrid::Ptr grid;  ///< level set
  double voxelSize = 0;
  double gap = 0;  ///< usual distance between neighbouring planes, world units
  /// largest distance of a contour point to the surface, world units, to first order
  double farthestContour = 0;
  Notes notes;
};

/// Default voxel size, world units: 0.6 of the usual distance between a contour's points and at most 0.3 of
/// the usual gap between planes, so that the surface follows the contours to within half a voxel; never so
/// small that the lattice gets too large. Throws as contourSurface.
double contourVoxelSize(const ContourSet& set);

/// The closed surface through an object's contours on planes in any position; planes may intersect. It is the
/// zero set of the function of least bending energy (thin plate) on a lattice that is zero on the contours
/// and close to the planes' own signed distances near them, solved from coarse to fine (after [TO99], on a
/// lattice). An object is closed within about half a gap beyond its last plane. The result does not depend on
/// the thread count. Throws GeometryError without contours, or if all of them are on one plane; InputError if
/// the voxel size is not positive or the lattice would be too large; Cancelled.
ContourSurface contourSurface(const ContourSet& set, const ContourSurfaceOptions& options = {},
                              Progress* progress = nullptr);

/// The mesh of a contour surface: closed, manifold, and moved onto the contour points where meshing the level
/// set cuts their corners.
Mesh contourMesh(const ContourSet& set, const ContourSurface& surface);

}  // namespace slicemorph
