#pragma once

#include "tools/job/make_frame.h"

namespace slicemorph {

/// The grids of a frame.
struct CarriedGrids {
  openvdb::GridCPtrVec grids;           ///< in the order of the output
  openvdb::GridBase::ConstPtr density;  ///< one of these: the fog that the shapes were found in; null: none
};

/// Adds to a frame's `grids` the pullback of the inputs' other grids, and the velocities if they are wanted.
/// `where`: the grid whose voxels velocities are put on, unless there is fog; null: the first other grid.
/// `half`: velocities are stored as half floats. Throws Cancelled between two grids; InputError for grids
/// that do not fit together; IoError.
CarriedGrids carryGrids(const FrameTask& task, openvdb::GridBase::ConstPtr where, openvdb::GridCPtrVec grids,
                        bool half, const Progress& cancel);

/// The morph's velocities around the active voxels of a grid, as `carryGrids` makes them; null where none are wanted, the
/// job has no speed or the method no map. Of frames whose grids are not carried.
openvdb::Vec3SGrid::ConstPtr velocityAround(const FrameTask& task, const openvdb::GridBase& where);

}  // namespace slicemorph
