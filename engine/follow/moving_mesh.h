#pragma once

#include "slicemorph/mesh.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// A mesh that keeps its triangles over some frames of a morph while its points move.
struct MovingMesh {
  size_t first = 0;                                      ///< the frame of its first points, from 0
  std::vector<openvdb::Vec3I> triangles;                 ///< none for a frame in which nothing is to be seen
  std::vector<std::vector<openvdb::Vec3s>> points;       ///< per frame, world
  std::vector<std::vector<openvdb::Vec3s>> colors = {};  ///< per frame and point; or none
};

struct SurfaceFrame {
  FloatGrid::ConstPtr surface;  ///< level set
  Weights weights;
  openvdb::Vec3SGrid::ConstPtr colors = nullptr;  ///< around the surface; null: it has none
};

/// How far a moving mesh may be from a frame's own surface to stand for it.
struct FollowLimits {
  double most = 3;        ///< voxels from any vertex of the frame's own mesh to the moving one
  double p99 = 0.75;      ///< voxels from 99 % of them
  double mean = 0.1;      ///< voxels too large or too small all over: its volume's error by the area
  double inwards = 0.01;  ///< share of the area whose triangles face inwards: folds
};

/// The surfaces of a morph's frames, each frame in one mesh, with as few meshes as are found: the mesh of the
/// frame in the middle is carried by the plan's map to its neighbours and on, and moved onto each one's
/// surface, for as long as it stays within the limits; what is left before and after it is done in the same
/// way. At the worst each frame has its own mesh. Without a plan (null) each has. The meshes have colours
/// where all frames that are to be seen have. Throws Cancelled.
std::vector<MovingMesh> followSurfaces(const std::vector<SurfaceFrame>& frames, const MorphPlan* plan,
                                       const FollowLimits& limits = {}, Progress* progress = nullptr);

}  // namespace slicemorph
