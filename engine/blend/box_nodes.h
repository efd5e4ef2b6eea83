#pragma once

#include "engine/blend/find_nodes.h"

#include <functional>

namespace slicemorph {

/// The fields to evaluate at nodes.
struct NodeFields {
  std::vector<const VectorField*> onLattice;  ///< values at the lattice's nodes
  /// Value of a field at a chart point beyond the lattice.
  std::function<openvdb::Vec3s(const Vec3d& q, size_t field)> beyond;
};

/// The nodes around the voxels of a box of index space, and one more node on every side for spline interpolation,
/// without values. `step`: voxels between nodes.
NodeMap emptyNodes(const openvdb::CoordBBox& box, int step);

/// Evaluates fields at all nodes of emptyNodes().
NodeMap boxNodes(const openvdb::CoordBBox& box, const Lattice& lattice, const LatticePose& pose,
                 const openvdb::math::Transform& transform, int step, const NodeFields& fields);

/// Finds where nodes of an in-between's maps lie in its lattice; for several sets of nodes of one transform and step.
class PlaceFinder {
 public:
  /// All must outlive this.
  PlaceFinder(const Lattice& lattice, const LatticePose& pose, const openvdb::math::Transform& transform,
              int step);
  /// Places those nodes of a map that `wanted` marks, one flag a node, and some others; what is placed is known.
  NodeMap find(NodeMap map, const std::vector<char>& wanted) const;

 private:
  openvdb::BBoxd boxOfCells(const openvdb::Coord& first, int cells) const;
  std::vector<char> cellsWith(const NodeMap& map, const std::vector<char>& wanted) const;

  const Lattice& lattice_;
  const LatticePose& pose_;
  const openvdb::math::Transform& transform_;
  int step_;
  openvdb::Coord blockCount_;
  std::vector<openvdb::BBoxd> blocks_;  ///< of each block of cells: the box of its nodes, in nodes of the map
};

/// Box in the in-between's index space around what an object has inside a world box.
openvdb::BBoxd boxOnPose(const LatticeOnObjects& on, size_t object, const openvdb::BBoxd& world,
                         const LatticePose& pose, const openvdb::math::Transform& transform);

}  // namespace slicemorph
