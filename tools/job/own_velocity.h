#pragma once

#include "tools/job/frame_content.h"

namespace slicemorph {

/// Whether a set holds velocities that are the inputs' own: a grid of vectors, or one that was joined of three.
bool isOwnVelocity(const GridSet& set, const openvdb::GridBase& grid, const VelocitySettings& velocity);

/// A grid of vectors times a factor; the grid itself where that is 1.
openvdb::GridBase::ConstPtr scaledVectors(const openvdb::GridBase::ConstPtr& grid, double factor);

/// Writes a frame that shows a VDB file, `job.given`: the same bytes, but for velocities (vel, v, velocity, or their
/// components as vel.x), which are `job.speed` times as large; and of --grids only those. Throws IoError.
void copyAtSpeed(const FrameJob& job, const MorphSettings& settings);

}  // namespace slicemorph
