#pragma once

#include "engine/volume/distance_field.h"

#include <functional>
#include <limits>
#include <queue>
#include <utility>
#include <vector>

namespace slicemorph {

/// The inside of an object as points of a coarse regular grid.
struct InsideNodes {
  /// At most `most` points, of the field's coarse nodes; `along`: about so many along the longest side, or fewer.
  explicit InsideNodes(const DistanceField& field, size_t most = 40000,
                       int along = std::numeric_limits<int>::max());

  std::vector<Vec3d> position;     ///< world
  std::vector<double> share;       ///< of each point's cell that is inside, 0 to 1
  std::vector<double> depth;       ///< distance to the surface; below zero just outside
  std::vector<openvdb::Coord> at;  ///< in the coarse grid
  double spacing = 0;              ///< world units

  double volume() const;
  /// The share of a point that counts for a body's graph: 0 where the point is outside by a quarter of the spacing or
  /// more, else at least 0.05, so that thin limbs hold together.
  double bodyShare(size_t i) const;
};

/// Lengths of the shortest paths from one of `count` nodes to all (Dijkstra); infinite where there is none.
/// `eachNeighbour(node, visit)` calls visit(neighbour, length of the step).
template <typename EachNeighbour>
std::vector<double> shortestPaths(size_t count, size_t start, const EachNeighbour& eachNeighbour) {
  std::vector<double> length(count, std::numeric_limits<double>::infinity());
  using Entry = std::pair<double, size_t>;
  std::priority_queue<Entry, std::vector<Entry>, std::greater<Entry>> queue;
  length[start] = 0;
  queue.push({0, start});
  while (!queue.empty()) {
    const auto [d, i] = queue.top();
    queue.pop();
    if (d > length[i]) continue;
    eachNeighbour(i, [&, d = d](size_t next, double step) {
      if (d + step < length[next]) queue.push({length[next] = d + step, next});
    });
  }
  return length;
}

/// Shortest paths through the inside, along steps between the 26 neighbours of each node (Dijkstra).
class Geodesics {
 public:
  explicit Geodesics(const InsideNodes& nodes);

  struct Distances {
    std::vector<double> length;  ///< per node, world units; infinite where there is no path
    /// The farthest node that is reachable.
    size_t farthest() const;
  };
  Distances from(size_t start) const;

  struct Neighbour {
    size_t node;
    double distance;
  };
  const std::vector<Neighbour>& neighbours(size_t node) const { return neighbours_[node]; }

 private:
  std::vector<std::vector<Neighbour>> neighbours_;
};

}  // namespace slicemorph
