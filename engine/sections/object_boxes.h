#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Grid types that can be sliced: numbers, vectors and flags.
using SliceableTypes = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid,
                                         openvdb::Vec3DGrid, openvdb::Vec3IGrid, openvdb::Int32Grid,
                                         openvdb::Int64Grid, openvdb::BoolGrid, openvdb::MaskGrid>;

/// Whether a grid is of one of these types.
bool isSliceable(const openvdb::GridBase& grid);

/// Index-space boxes that cover a grid's object: the inside of a level set (in the band or not), else the
/// active voxels. One box per tile and per full leaf, otherwise per run along z. The order is deterministic.
std::vector<openvdb::CoordBBox> objectBoxes(const openvdb::GridBase& grid);

}  // namespace slicemorph
