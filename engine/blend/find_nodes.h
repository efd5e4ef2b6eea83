#pragma once

#include "engine/blend/lattice_pose.h"
#include "engine/blend/node_map.h"

#include <tbb/parallel_for.h>

namespace slicemorph {

/// An in-between's lattice in a frame's index space, and the fields to interpolate between its nodes.
struct PosedLattice {
  const Lattice& lattice;
  const LatticePose& pose;
  std::vector<const VectorField*> fields;  ///< one vector per lattice node
  std::vector<Vec3d> node;                 ///< index-space position over the map's step
  std::vector<char> near;                  ///< per cell (at its first node): whether to search it
  double handed = 1;  ///< -1: the frame's index space is mirrored, and so is every tetrahedron
};

/// `step`: voxels between a map's nodes.
PosedLattice posedLattice(const Lattice& lattice, const LatticePose& pose,
                          std::vector<const VectorField*> fields, const openvdb::math::Transform& transform,
                          int step);

/// Interpolates the fields at the nodes of a map's box that lie in one of the lattice's tetrahedra, by
/// barycentric coordinates. Where slices of a bent chart cross, several tetrahedra hold a node: the one with
/// the smallest blended distance wins.
void findNodes(const PosedLattice& posed, NodeMap& map);

/// Calls `action(q, n)` in parallel for every node n that is not known, with its chart point q; `action` may
/// mark the node as known.
template <typename Action>
void forUnknownNodes(const NodeMap& map, const Chart& chart, const openvdb::math::Transform& transform,
                     const Action& action) {
  tbb::parallel_for(0, int(map.size[2]), [&](int z) {
    for (int y = 0; y < map.size[1]; ++y)
      for (int x = 0; x < map.size[0]; ++x) {
        const openvdb::Coord c = map.origin + openvdb::Coord(x, y, z);
        const size_t n = map.index(c[0], c[1], c[2]);
        if (!map.known[n]) action(chart.toChart(transform.indexToWorld(map.step * c.asVec3d())), n);
      }
  });
}

}  // namespace slicemorph
