#pragma once

#include "engine/blend/node_map.h"
#include "engine/volume/leaf.h"

#include <array>
#include <functional>

namespace slicemorph {

/// Origins of the leaves that hold at least one cell for which `active(i, j, k)` is true, where (i, j, k) is
/// the cell's first node; in a fixed order. A leaf's side is a multiple of every node step.
std::vector<openvdb::Coord> leavesWith(const NodeMap& nodes,
                                       const std::function<bool(int, int, int)>& active);

/// Interpolates a map's vectors at the voxels between its nodes: for a backward map the voxels'
/// positions on the objects.
class NodePositions {
 public:
  /// `nodes` must outlive this.
  explicit NodePositions(const NodeMap& nodes);

  /// Positions of the step^3 voxels of the cell whose first node is (i, j, k), x slowest, relative to the
  /// field's anchor: by Catmull-Rom splines [CR74] where all 64 nodes around are known, else trilinear.
  void find(int i, int j, int k, size_t object, std::vector<openvdb::Vec3s>& positions) const;
  /// Whether neighbours among `side` x `side` x `side` nodes from (i, j, k) on lie on crossing slices of a
  /// bent chart, so that positions between them are undefined.
  bool torn(int i, int j, int k, int side, size_t object) const;

 private:
  void findLinearly(int i, int j, int k, size_t object, std::vector<openvdb::Vec3s>& positions) const;

  const NodeMap& nodes_;
  int step_;
  std::vector<std::array<float, 4>>
      spline_;  ///< weights of nodes -1, 0, 1, 2 at the fractions 0, 1/step, ...
};

}  // namespace slicemorph
