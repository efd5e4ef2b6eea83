#pragma once

#include "engine/blend/lattice_on_objects.h"

namespace slicemorph {

/// Assumed largest gradient of the blend of the objects' distances (a distance has 1). Chosen by hand;
/// guarded by MovingLattice.NodesCoverTheBand and Morph.BandOfLargeVoxelsIsWhole.
constexpr double kSteepest = 1.3;

/// A map counts as folded where a tetrahedron keeps less than this share of its volume. Chosen by hand.
constexpr double kFoldedBelow = 0.05;

/// The lattice nodes' positions on one in-between.
struct LatticePose {
  Chart chart;                  ///< blended; bent ones are moved so that the centroid's path is straight
  Weights mean;                 ///< of the objects; with regions, the mean over the in-between's inside
  std::vector<Vec3d> at;        ///< per node: chart coordinates
  std::vector<Vec3d> world;     ///< per node
  std::vector<float> distance;  ///< per node: blended, chart units
  int straightening = 0;  ///< rounds of widening borders or straightening paths that it took to avoid folds
};

/// Weights per node and object; empty where they are the same everywhere.
using NodeWeights = std::vector<float>;

/// Chart position of a node on an in-between, by the map alone. `middle`: of the node in the middle space; `path`: the
/// pathWeights of the in-between.
Vec3d onPath(const LatticeOnObjects& on, size_t node, const Vec3d& middle, const Weights& path);

/// A pose without `chart` and `world`. `local`: empty, or weights per node. `offsets`: per node, chart units;
/// empty where paths are not bent by ContourPaths.
LatticePose blendedPose(const LatticeOnObjects& on, const Weights& weights, const NodeWeights& local,
                        const VectorField& offsets);

/// Displacements of the lattice's nodes from the middle space, chart units.
VectorField displacementOf(const Lattice& lattice, const LatticePose& pose);

/// World positions of a pose's nodes by a chart.
std::vector<Vec3d> worldOf(const LatticePose& pose, const Chart& chart);

/// Whether a tetrahedron near the surface folds; with weights per node, only cells where the
/// weights differ are tested.
bool poseFolds(const LatticeOnObjects& on, const LatticePose& pose, const NodeWeights& local);

/// World centroid of the inside, summed over cells weighted by their world volume and the share of it inside. `world`: the
/// nodes' positions by the chart.
Vec3d poseCentroid(const Lattice& lattice, const LatticePose& pose, const std::vector<Vec3d>& world,
                   const Chart& chart);

}  // namespace slicemorph
