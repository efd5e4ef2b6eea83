#pragma once

#include "slicemorph/conventions.h"

namespace slicemorph {

/// Grid types that can be sliced: numbers, vectors and flags.
using SliceableTypes = openvdb::TypeList<FloatGrid, openvdb::DoubleGrid, openvdb::Vec3SGrid,
                                         openvdb::Vec3DGrid, openvdb::Vec3IGrid, openvdb::Int32Grid,
                                         openvdb::Int64Grid, openvdb::BoolGrid, openvdb::MaskGrid>;

/// Whether a grid is of one of these types.
bool isSliceable(const openvdb::GridBase& grid);

/// Boxes of index space that hold a grid's object: a level set's inside, in the band or not, else the active
/// voxels. Tiles and leaves that are full are one box each, others the runs of their rows. Always in the same
/// order.
std::vector<openvdb::CoordBBox> objectBoxes(const openvdb::GridBase& grid);

}  // namespace slicemorph
