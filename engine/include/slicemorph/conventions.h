#pragma once

/// Conventions of all of slicemorph; other headers state only what differs.
///
/// - World space: the input's units (millimetres, LPS, for medical data), right-handed.
/// - Index space: OpenVDB's; a voxel's value belongs to its centre, the integer coordinate.
/// - Level set: signed distance in world units, negative inside, narrow band of half width 3 voxels, grid
///   class GRID_LEVEL_SET, uniform voxels with axes parallel to the world's.
/// - Triangles: wound so that (b - a) x (c - a) points outwards.
/// - Chart space (u, x, y): u in [-1, 1] along the spine, (x, y) in the slice plane, in units of the
///   coordinate frame's radius.
/// - Time t in [0, 1]; t = 0 is the first input. A morph of N objects is given by N weights that sum to 1,
///   each >= 0 (or a little less, where splines through keys overshoot); a two-object morph at t has the
///   weights (1 - t, t).

#include "slicemorph/grids.h"

#include <vector>

namespace slicemorph {

using openvdb::FloatGrid;
using openvdb::Mat3d;
using openvdb::Vec3d;

/// Half width of every narrow band, in voxels: OpenVDB's LEVEL_SET_HALF_WIDTH.
constexpr double kHalfWidth = 3.0;

/// One weight per object.
using Weights = std::vector<double>;

}  // namespace slicemorph
