#pragma once

#include "engine/volume/distance_field.h"

namespace slicemorph {

/// The inside of an object as some 40,000 points of a coarse grid at most.
struct InsideNodes {
  explicit InsideNodes(const DistanceField& field);

  std::vector<Vec3d> position;     ///< world
  std::vector<double> share;       ///< of each one's cell, that is inside
  std::vector<double> depth;       ///< distance to the surface; below zero just outside
  std::vector<openvdb::Coord> at;  ///< in the coarse grid
  double spacing = 0;              ///< world units

  double volume() const;
};

/// Shortest ways through the inside, from node to neighbouring node.
class Geodesics {
 public:
  explicit Geodesics(const InsideNodes& nodes);

  struct Ways {
    std::vector<double> length;  ///< infinite where there is no way
    /// The farthest node that can be reached.
    size_t farthest() const;
  };
  Ways from(size_t start) const;

  struct Neighbour {
    size_t node;
    double distance;
  };
  const std::vector<Neighbour>& neighbours(size_t node) const { return neighbours_[node]; }

 private:
  std::vector<std::vector<Neighbour>> neighbours_;
};

}  // namespace slicemorph
