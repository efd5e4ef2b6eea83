#pragma once

#include "engine/blend/lattice_pose.h"
#include "engine/blend/node_map.h"

#include <functional>

namespace slicemorph {

/// What is to be found at the nodes: fields on the lattice, and what nodes beyond it have at a chart point.
struct NodeFields {
  std::vector<const VectorField*> onLattice;
  std::function<openvdb::Vec3s(const Vec3d& q, size_t field)> beyond;
};

/// All nodes around the voxels of a box of index space, one node more on every side for the splines.
NodeMap boxNodes(const openvdb::CoordBBox& box, const Lattice& lattice, const LatticePose& pose,
                 const openvdb::math::Transform& transform, int step, const NodeFields& fields);

/// Where what an object has in a box of the world lies on the in-between: a box of index space.
openvdb::BBoxd boxOnPose(const LatticeOnObjects& on, size_t object, const openvdb::BBoxd& world,
                         const LatticePose& pose, const openvdb::math::Transform& transform);

}  // namespace slicemorph
