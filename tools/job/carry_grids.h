#pragma once

#include "tools/job/make_frame.h"

namespace slicemorph {

/// Grids of a frame.
struct CarriedGrids {
  openvdb::GridCPtrVec grids;           ///< in their order
  openvdb::GridBase::ConstPtr density;  ///< of these, the fog that the shapes are part of; null: none
};

/// Adds to a frame's `grids` those that ride along with its shape, and the velocities where these are wanted.
/// `where`: on whose voxels velocities are, unless there is fog; null: the first grid that rides along.
/// `half`: velocities are stored as half floats. Throws Cancelled between two grids; InputError for grids
/// that do not fit together, IoError.
CarriedGrids carryGrids(const FrameTask& task, openvdb::GridBase::ConstPtr where, openvdb::GridCPtrVec grids,
                        bool half, const Progress& cancel);

}  // namespace slicemorph
