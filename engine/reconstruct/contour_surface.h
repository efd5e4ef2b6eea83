#pragma once

#include "engine/reconstruct/contour_planes.h"
#include "slicemorph/mesh.h"
#include "slicemorph/note.h"
#include "slicemorph/progress.h"

namespace slicemorph {

struct ContourSurfaceOptions {
  double voxelSize = 0;  ///< world units; 0: by the contours' sampling, see contourVoxelSize
};

struct ContourSurface {
  FloatGrid::Ptr grid;  ///< level set
  double voxelSize = 0;
  double gap = 0;              ///< usual distance between neighbouring planes, world units
  double farthestContour = 0;  ///< largest distance of a given contour point to the surface (to first order)
  Notes notes;
};

/// 0.6 of the usual distance between a contour's points, at most 0.3 of the usual gap between planes, so that
/// the surface follows the contours closer than half a voxel.
double contourVoxelSize(const ContourSet& set);

/// The closed surface through an object's contours on planes in any position, also planes that cross each
/// other: the function of least bending (thin plate) over a lattice, zero on the contours and close to the
/// planes' own signed distances near them, found from coarse to fine (after [TO99], on a
/// lattice). An object is closed within about half a gap beyond its last plane. The same for any number of
/// threads. Throws GeometryError where there are no contours, or all lie on one plane; InputError where the
/// voxel size is not positive or the lattice would be absurdly large; Cancelled.
ContourSurface contourSurface(const ContourSet& set, const ContourSurfaceOptions& options = {},
                              Progress* progress = nullptr);

/// The mesh of a contour surface: closed and manifold, moved onto the contour points where meshing the level
/// set cuts their corners.
Mesh contourMesh(const ContourSet& set, const ContourSurface& surface);

}  // namespace slicemorph
