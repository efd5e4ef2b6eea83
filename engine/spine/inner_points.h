#pragma once

#include <array>
#include <cstddef>
#include <functional>
#include <vector>

namespace slicemorph {

/// The inside of an object as nodes that are joined to each other.
struct InnerNodes {
  std::vector<double> share;  ///< per node: how much of it counts; those of 0 are left out
  size_t deepest = 0;         ///< the node farthest from the surface
  /// Distances from a node to all, along paths inside; infinite where there is none.
  std::function<std::vector<double>(size_t)> distancesFrom;
};

/// Some of the nodes, spread evenly by inner distance, and what tells them apart wherever the object's limbs are.
struct InnerPoints {
  std::vector<size_t> node;    ///< each the farthest from those before, so that fewer are the first of more
  std::vector<double> weight;  ///< sum 1
  std::vector<std::vector<double>> toNodes;   ///< per point: distances to all nodes, as the nodes' own
  std::vector<std::vector<double>> distance;  ///< between the points, over `unit`; symmetric
  double unit = 1;                            ///< their weighted root mean square
  /// Per point: logarithms of the shares of the volume within two inner distances of it.
  std::vector<std::array<double, 2>> fullness;

  /// Mean squared difference of two points' fullness.
  static double unlike(const std::array<double, 2>& a, const std::array<double, 2>& b) {
    return 0.5 * ((a[0] - b[0]) * (a[0] - b[0]) + (a[1] - b[1]) * (a[1] - b[1]));
  }
};

/// At most `count` points, fewer where there are fewer nodes; none where no node counts.
InnerPoints innerPoints(const InnerNodes& nodes, size_t count);

/// What innerPoints finds for a smaller `count`, by the paths known already. `share`: that of the nodes.
InnerPoints fewerOf(const InnerPoints& points, size_t count, const std::vector<double>& share);

}  // namespace slicemorph
