#pragma once

#include "slicemorph/mesh.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// A mesh that keeps its triangles over several frames of a morph while its points move.
struct MovingMesh {
  size_t first = 0;                                      ///< frame of its first points, from 0
  std::vector<openvdb::Vec3I> triangles;                 ///< empty for a frame in which nothing is visible
  std::vector<std::vector<openvdb::Vec3s>> points;       ///< per frame; world
  std::vector<std::vector<openvdb::Vec3s>> colors = {};  ///< per frame and point; or empty
};

struct SurfaceFrame {
  FloatGrid::ConstPtr surface;  ///< level set
  Weights weights;
  openvdb::Vec3SGrid::ConstPtr colors = nullptr;  ///< on voxels around the surface; null: it has none
};

/// How far a moving mesh may be from a frame's own surface to represent it. Defaults chosen by hand;
/// follow_test.cpp uses them.
struct FollowLimits {
  double most = 3;        ///< voxels from any vertex of the frame's own mesh to the moving one
  double p99 = 0.75;      ///< voxels from 99 % of them
  double mean = 0.1;      ///< voxels too large or too small in the mean: difference of volumes over the area
  double inwards = 0.01;  ///< share of the area whose triangles face inwards because of folds
};

/// The surfaces of a morph's frames, in as few meshes as found. The mesh of the middle frame is carried by
/// the plan's map to the neighbouring frames, in both directions, and moved onto each one's surface, for as
/// long as it stays within the limits; the frames left before and after are processed in the same way. In the
/// worst case each frame has its own mesh; without a plan (null) each has. Colours are set if all frames with
/// a surface have them. Throws Cancelled.
std::vector<MovingMesh> followSurfaces(const std::vector<SurfaceFrame>& frames, const MorphPlan* plan,
                                       const FollowLimits& limits = {}, Progress* progress = nullptr);

}  // namespace slicemorph
