#pragma once

#include "engine/blend/contour_paths.h"
#include "engine/blend/lattice_pose.h"
#include "engine/blend/local_weights.h"
#include "engine/blend/node_map.h"

#include <optional>

namespace slicemorph {

/// The matching's lattice, made to move: its nodes have a position on every object and so on every in-between.
/// Between the nodes the map is linear on tetrahedra; without folds it is one to one, and its inverse exact.
class MovingLattice {
 public:
  using Pose = LatticePose;

  /// `regions`: of the objects; none: weights are the same everywhere. `paths`: null: points go straight on.
  MovingLattice(const Displacements& map, const Fields& fields, const std::vector<Chart>& charts,
                std::shared_ptr<const RegionShares> regions = nullptr,
                std::shared_ptr<const ContourPaths> paths = nullptr);

  Pose poseAt(const Weights& weights) const;
  /// Of an object itself, whatever regions say.
  Pose poseOf(size_t object) const;
  /// The weights at each position of such an in-between.
  LocalWeights localWeights(const Weights& weights) const { return {weights, regions_.get()}; }
  /// Where what one in-between has at some world points is on another one.
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, const Pose& from, const Pose& to) const;

  /// As surfaceNodes.
  NodeMap nodesNearSurface(const Pose& pose, const openvdb::math::Transform& transform, int step) const;
  /// As boxOnPose.
  openvdb::BBoxd boxOf(size_t object, const openvdb::BBoxd& world, const Pose& pose,
                       const openvdb::math::Transform& transform) const;
  /// All nodes around the voxels of a box of index space: near the objects by the lattice, further out by the
  /// charts alone.
  NodeMap nodesWithin(const openvdb::CoordBBox& box, const Pose& pose,
                      const openvdb::math::Transform& transform, int step) const;
  /// How fast what is at each node moves while the weights change by `rate` a unit of time (of sum 0): world
  /// units per that time, as of one object. Nodes as nodesWithin.
  NodeMap velocitiesWithin(const openvdb::CoordBBox& box, const Weights& weights, const Weights& rate,
                           const Pose& pose, const openvdb::math::Transform& transform, int step) const;

 private:
  NodeWeights nodeWeights(const Weights& weights) const;
  NodeWeights smoothed(const NodeWeights& weights) const;
  Pose poseAt(const Weights& weights, std::optional<int> straightening) const;
  Pose blendUnfolded(const Weights& weights, const NodeWeights& local,
                     std::optional<int> straightening) const;

  LatticeOnObjects on_;
  std::vector<Vec3d> centroid_;  ///< per object, by poseCentroid; where charts are bent
  std::shared_ptr<const RegionShares> regions_;
  std::vector<std::vector<float>> share_;  ///< per region: of each node
  std::shared_ptr<const ContourPaths> paths_;
};

}  // namespace slicemorph
