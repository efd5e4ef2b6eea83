#pragma once

#include "engine/volume/distance_field.h"

namespace slicemorph {

/// The inside of an object as points of a coarse regular grid.
struct InsideNodes {
  /// At most `most` points: of the field's coarse nodes every `leastStride`-th along each axis, or fewer.
  explicit InsideNodes(const DistanceField& field, size_t most = 40000, int leastStride = 1);

  std::vector<Vec3d> position;     ///< world
  std::vector<double> share;       ///< of each point's cell that is inside, 0 to 1
  std::vector<double> depth;       ///< distance to the surface; below zero just outside
  std::vector<openvdb::Coord> at;  ///< in the coarse grid
  double spacing = 0;              ///< world units

  double volume() const;
};

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
