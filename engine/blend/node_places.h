#pragma once

#include "engine/blend/node_map.h"
#include "engine/volume/leaf.h"

#include <array>
#include <functional>

namespace slicemorph {

/// Origins of the leaves (whose side is a multiple of every node step) with a cell, given by its first node, that `active(i, j, k)` says is wanted; in
/// order.
std::vector<openvdb::Coord> leavesWith(const NodeMap& nodes,
                                       const std::function<bool(int, int, int)>& active);

/// Where the voxels between a map's nodes lie on the objects.
class NodePlaces {
 public:
  explicit NodePlaces(const NodeMap& nodes);

  /// Places of the step^3 voxels of the cell whose first node is (i, j, k), x slowest, relative to the
  /// field's anchor: splined where all 64 nodes around are known, else trilinear.
  void find(int i, int j, int k, size_t object, std::vector<openvdb::Vec3s>& places) const;
  /// Whether neighbours among `side` x `side` x `side` nodes lie on crossing slices of a bent chart: then
  /// nothing can be said of the places between them.
  bool torn(int i, int j, int k, int side, size_t object) const;

 private:
  void findLinearly(int i, int j, int k, size_t object, std::vector<openvdb::Vec3s>& places) const;

  const NodeMap& nodes_;
  int step_;
  std::vector<std::array<float, 4>>
      spline_;  ///< weights of nodes -1, 0, 1, 2 at the fractions 0, 1/step, ...
};

}  // namespace slicemorph
