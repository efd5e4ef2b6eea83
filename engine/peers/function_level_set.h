#pragma once

#include "slicemorph/conventions.h"

#include <functional>

namespace slicemorph {

/// A function of world points, negative inside; one per task, so that it may keep what it found last.
using PointFunction = std::function<float(const Vec3d&)>;

/// A box in which a function is looked at everywhere.
struct FunctionBox {
  openvdb::BBoxd box;  ///< world units
  double voxelSize = 0;
  const char* method;  ///< for the message of InputError
};

/// Level set named "surface" of a function's zero set in a box, at whose faces it is cut off where it reaches them (to a
/// voxel). The function need be no distance,
/// but change by no more than twelve voxels from voxel to voxel where it is 0. Throws InputError for more than 2^30
/// voxels; only the leaves near the surface are kept in memory.
FloatGrid::Ptr levelSetOfFunction(const FunctionBox& where, const std::function<PointFunction()>& function);

/// A level set named "surface" without any inside.
FloatGrid::Ptr emptyLevelSet(double voxelSize);

}  // namespace slicemorph
