#pragma once

#include "engine/blend/lattice_pose.h"
#include "engine/blend/node_map.h"

#include <functional>

namespace slicemorph {

/// The fields to evaluate at nodes.
struct NodeFields {
  std::vector<const VectorField*> onLattice;  ///< values at the lattice's nodes
  /// Value of a field at a chart point beyond the lattice.
  std::function<openvdb::Vec3s(const Vec3d& q, size_t field)> beyond;
};

/// Evaluates fields at all nodes around the voxels of a box of index space, and one more node on every side
/// for spline interpolation. `step`: voxels between nodes.
NodeMap boxNodes(const openvdb::CoordBBox& box, const Lattice& lattice, const LatticePose& pose,
                 const openvdb::math::Transform& transform, int step, const NodeFields& fields);

/// Box in the in-between's index space around what an object has inside a world box.
openvdb::BBoxd boxOnPose(const LatticeOnObjects& on, size_t object, const openvdb::BBoxd& world,
                         const LatticePose& pose, const openvdb::math::Transform& transform);

}  // namespace slicemorph
