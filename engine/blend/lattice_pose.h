#pragma once

#include "engine/blend/lattice_on_objects.h"

namespace slicemorph {

/// How much faster than a distance the blend of the objects' distances may change.
constexpr double kSteepest = 1.3;

/// A map is folded where a tetrahedron keeps less than this share of its volume.
constexpr double kFoldedBelow = 0.05;

/// One in-between's positions of the lattice nodes.
struct LatticePose {
  Chart chart;               ///< blended, and bent ones moved so that the centroid travels straight
  Weights mean;              ///< of the objects: where regions have weights of their own, of the whole inside
  std::vector<Vec3d> at;     ///< per node: chart coordinates
  std::vector<Vec3d> world;  ///< per node
  std::vector<float> distance;  ///< per node: blended, chart units
  int straightening = 0;  ///< rounds that borders were widened, or paths straightened, lest anything folds
};

/// Weights per node and object; empty where they are the same everywhere.
using NodeWeights = std::vector<float>;

/// Without chart and world. `offsets`: per node, chart units; none where points go straight on.
LatticePose blendedPose(const LatticeOnObjects& on, const Weights& weights, const NodeWeights& local,
                        const VectorField& offsets);

/// Of the lattice's nodes from the middle space.
VectorField displacementOf(const Lattice& lattice, const LatticePose& pose);

/// The chart's world positions of a pose's nodes.
std::vector<Vec3d> worldOf(const LatticePose& pose, const Chart& chart);

/// Whether anything near the surface folds; where weights differ from node to node, at the borders between parts.
bool poseFolds(const LatticeOnObjects& on, const LatticePose& pose, const NodeWeights& local);

/// World centroid of the inside, cell by cell: each cell's volume in the world by the share of it that is inside.
Vec3d poseCentroid(const Lattice& lattice, const LatticePose& pose, const Chart& chart);

}  // namespace slicemorph
