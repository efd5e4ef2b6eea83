#pragma once

#include "engine/blend/lattice_pose.h"
#include "engine/blend/node_map.h"

#include <tbb/parallel_for.h>

#include <memory>

namespace slicemorph {

/// The cells of an in-between's lattice that are searched for the nodes of a map, in the frame's index space.
class PosedLattice {
 public:
  /// `near`: per cell (at its first node) whether to search it. `step`: voxels between a map's nodes. All but `near` must
  /// outlive this.
  PosedLattice(const Lattice& lattice, const LatticePose& pose, const openvdb::math::Transform& transform,
               int step, std::vector<char> near);

  /// Of the cells' nodes, in nodes of the map.
  const openvdb::BBoxd& box() const { return box_; }
  /// Finds the nodes of a map's box that lie in one of the cells' tetrahedra: sets their places and marks them as known,
  /// and no others. Where slices of a bent chart cross, several tetrahedra hold a node: the one with the smallest blended
  /// distance wins.
  void place(NodeMap& map) const;

 private:
  class SlabNodes;

  const Lattice& lattice_;
  const LatticePose& pose_;
  std::vector<char> near_;
  std::unique_ptr<Vec3d[]> node_;  ///< position in nodes of the map; only of the cells' nodes
  openvdb::BBoxd box_;
  double handed_ = 1;  ///< -1: the frame's index space is mirrored, and so is every tetrahedron
};

/// Position of a lattice's node in nodes of a map.
inline Vec3d inNodes(const LatticePose& pose, size_t node, const openvdb::math::Transform& transform,
                     int step) {
  return transform.worldToIndex(pose.world[node]) / step;
}

/// Evaluates fields (one vector per lattice node) at the known nodes of a map by their places.
void evaluateAtPlaces(const Lattice& lattice, const std::vector<const VectorField*>& fields, NodeMap& map);

/// Calls `action(c, n)` in parallel for every node c, number n.
template <typename Action>
void forNodes(const NodeMap& map, const Action& action) {
  tbb::parallel_for(0, int(map.size[2]), [&](int z) {
    for (int y = 0; y < map.size[1]; ++y)
      for (int x = 0; x < map.size[0]; ++x) {
        const openvdb::Coord c = map.origin + openvdb::Coord(x, y, z);
        action(c, map.index(c[0], c[1], c[2]));
      }
  });
}

/// Calls `action(q, n)` in parallel for every node n that is not known, with its chart point q; `action` may
/// mark the node as known.
template <typename Action>
void forUnknownNodes(const NodeMap& map, const Chart& chart, const openvdb::math::Transform& transform,
                     const Action& action) {
  forNodes(map, [&](const openvdb::Coord& c, size_t n) {
    if (!map.known[n]) action(chart.toChart(transform.indexToWorld(map.step * c.asVec3d())), n);
  });
}

}  // namespace slicemorph
