#pragma once

#include "engine/match/chart_samples.h"

namespace slicemorph {

/// The inside of an object as a few hundred to a few thousand nodes, each joined to its neighbours where the way
/// between them lies inside: limbs that lie next to each other are not joined across the gap.
struct BodyGraph {
  struct Edge {
    int from, to;
    float weight;  ///< 1 over the squared length in spacings, less where the nodes are partly outside
  };
  /// The nearest nodes of a point, all joined to the nearest one, and their weights; the sum of weights is 1.
  struct Binding {
    static constexpr int kNodes = 4;
    int node[kNodes];
    float weight[kNodes];
  };

  std::vector<Vec3d> position;  ///< chart coordinates of the chart given to bodyGraph
  std::vector<double> share;    ///< per node: how much of it is inside, 0.05 to 1
  size_t deepest = 0;           ///< the node farthest from the surface
  double depth = 0;             ///< its distance from the surface, chart units
  std::vector<Edge> edges;
  double spacing = 1;                        ///< chart units
  std::vector<std::vector<int>> neighbours;  ///< per node
  Binding bind(const Vec3d& point) const;    ///< `point`: chart coordinates
  /// Lengths of the shortest paths from a node to all, chart units; infinite where there is none.
  std::vector<double> distancesFrom(size_t node) const;
};

/// Where the nodes of a body's graph are.
struct BodyPose {
  std::vector<Vec3d> position;
  std::vector<Mat3d> rotation;  ///< per node: how it is turned; empty where that is not known
};

/// `chart`: straight, with the same scale along all axes. No nodes where nothing is inside.
BodyGraph bodyGraph(const DistanceField& field, const Chart& chart);

}  // namespace slicemorph
