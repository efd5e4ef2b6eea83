#pragma once

#include "engine/slicemorph.h"

namespace slicemorph {

/// Where what is at some world points of the in-between `from` is on the in-between `to`: the plan's velocities, integrated
/// by Heun's method in steps of at most 1/16 of the weights. `voxelSize`: world units between the places where velocities
/// are asked for. Throws InputError for weights that are none.
std::vector<Vec3d> ride(const MorphPlan& plan, std::vector<Vec3d> points, const Weights& from, const Weights& to,
                        double voxelSize);

}  // namespace slicemorph
