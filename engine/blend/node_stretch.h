#pragma once

#include "engine/blend/node_map.h"

namespace slicemorph {

/// How the map to one object turns and stretches space around the nodes of an in-between.
class NodeStretch {
 public:
  struct Local {
    openvdb::Mat3s rotation;  ///< directions of the in-between to those of the object, world
    float volume = 1;         ///< of the object per volume of the in-between; 0 where the map folds
  };
  /// `voxelPerWorld`: steps of the in-between's index space by steps in the world.
  NodeStretch(const NodeMap& nodes, size_t object, const Mat3d& voxelPerWorld);

  /// Inside the cell whose first node is (i, j, k), `fraction` of the cell's sides from there.
  Local at(int i, int j, int k, const openvdb::Vec3s& fraction) const;

 private:
  Mat3d jacobian(int i, int j, int k, size_t object) const;

  const NodeMap& nodes_;
  std::vector<Local> local_;
};

/// The rotation nearest to a matrix; identity where its determinant is not positive.
Mat3d nearestRotation(Mat3d m);

}  // namespace slicemorph
