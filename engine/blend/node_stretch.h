#pragma once

#include "engine/blend/node_map.h"

namespace slicemorph {

/// Rotation and volume change of the backward map to one object, around the nodes of an in-between.
class NodeStretch {
 public:
  struct Local {
    openvdb::Mat3s rotation;  ///< from the in-between's to the object's directions, world
    float volume = 1;         ///< volume on the object over volume on the in-between; 0 where the map folds
  };
  /// `voxelPerWorld`: derivative of the in-between's index coordinates by world coordinates.
  NodeStretch(const NodeMap& nodes, size_t object, const Mat3d& voxelPerWorld);

  /// In the cell whose first node is (i, j, k), at `fraction` (0 to 1 per axis) of its sides.
  Local at(int i, int j, int k, const openvdb::Vec3s& fraction) const;

 private:
  Mat3d jacobian(int i, int j, int k, size_t object) const;

  const NodeMap& nodes_;
  std::vector<Local> local_;
};

/// The rotation nearest to a matrix; identity where its determinant is not positive.
Mat3d polarRotation(Mat3d m);

}  // namespace slicemorph
