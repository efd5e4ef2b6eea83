#pragma once

#include "slicemorph/conventions.h"

/// Densities of two frames of what flows, blended where they lie on each other. Grids of floats and doubles; others stay
/// as they are.
namespace slicemorph {

/// Gives a blend (1 - t) a + t b the fine detail of the nearer one: what is left of b - a when it is smoothed over 2
/// voxels is taken by t^2 / (t^2 + (1 - t)^2) in place of t. Blending makes in-betweens softer than either, also right
/// beside the frames that are given, as details are seldom alike in both. Nothing becomes negative. `difference`: b - a,
/// on the blend's voxels.
void takeNearerDetail(openvdb::GridBase& blend, const openvdb::GridBase& difference, double t);

/// Sum of the active values times the volume of a voxel.
double totalOf(const openvdb::GridBase& grid);

/// Multiplies the values so that their total becomes this one; where it is 0 they stay.
void scaleToTotal(openvdb::GridBase& grid, double total);

}  // namespace slicemorph
