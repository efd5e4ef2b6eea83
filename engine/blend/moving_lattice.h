#pragma once

#include "engine/blend/contour_paths.h"
#include "engine/blend/lattice_pose.h"
#include "engine/blend/local_weights.h"
#include "engine/blend/node_map.h"
#include "engine/blend/path_tangents.h"
#include "engine/blend/swing_paths.h"
#include "engine/blend/velocity_finder.h"

#include <optional>

namespace slicemorph {

/// The map of in-betweens: the matching's lattice, whose nodes have a position on every object and so on
/// every in-between. Between the nodes the map is linear on tetrahedra [Kuh60]; without folds it is one to
/// one and its inverse is exact.
class MovingLattice {
 public:
  using Pose = LatticePose;

  /// `regions`: null if weights are the same everywhere. `paths`: null if the map's own paths are used.
  /// `swings`: of these, what turns far goes on arcs, see SwingPaths.
  MovingLattice(const Displacements& map, const Fields& fields, const std::vector<Chart>& charts,
                std::shared_ptr<const RegionShares> regions = nullptr,
                std::shared_ptr<const ContourPaths> paths = nullptr, bool swings = false);

  /// Not where weights differ by region. See PathTangents.
  void passSmoothly(const std::array<PathTangents::Neighbour, 2>& of);

  /// Pose of an in-between.
  Pose poseAt(const Weights& weights) const;
  /// Pose of an object itself, ignoring regions.
  Pose poseOf(size_t object) const;
  /// The weights at each position of the in-between of `weights`.
  LocalWeights localWeights(const Weights& weights) const { return {weights, regions_.get()}; }
  /// Maps world points of one in-between to another one.
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, const Pose& from, const Pose& to) const;

  /// See surfaceNodes.
  NodeMap nodesNearSurface(const Pose& pose, const openvdb::math::Transform& transform, int step) const;
  /// See boxOnPose.
  openvdb::BBoxd boxOf(size_t object, const openvdb::BBoxd& world, const Pose& pose,
                       const openvdb::math::Transform& transform) const;
  /// All nodes around the voxels of a box of index space, with their positions on every object: inside the
  /// lattice by the map, beyond it by the charts alone.
  NodeMap nodesWithin(const openvdb::CoordBBox& box, const Pose& pose,
                      const openvdb::math::Transform& transform, int step) const;
  /// How the lattice moves while the weights change by `rate` (sum 0) per unit of time. This must outlive it.
  LatticeMotion motionAt(const Weights& weights, const Weights& rate, const Pose& pose) const;
  /// Finds velocities at nodes. All must outlive it.
  VelocityFinder velocityFinder(const LatticeMotion& motion, const Pose& pose,
                                const openvdb::math::Transform& transform, int step) const {
    return VelocityFinder(motion, on_.lattice, pose, transform, step);
  }

 private:
  NodeWeights nodeWeights(const Weights& weights) const;
  VectorField offsetsAt(const Weights& weights) const;
  NodeWeights smoothed(const NodeWeights& weights) const;
  Pose poseAt(const Weights& weights, std::optional<int> straightening) const;
  Pose uncentredPose(const Weights& weights, std::optional<int> straightening) const;
  LatticeMotion plainMotion(const Weights& earlier, const Weights& later, double unit,
                            int straightening) const;
  Vec3d shiftToCentre(const Pose& pose, const std::vector<Vec3d>& world) const;
  Vec3d centroidOf(size_t object, const Chart& chart) const;
  Pose blendUnfolded(const Weights& weights, const NodeWeights& local,
                     std::optional<int> straightening) const;

  LatticeOnObjects on_;
  std::vector<Vec3d> centroid_;  ///< per object, by poseCentroid; where charts are bent
  std::shared_ptr<const RegionShares> regions_;
  std::vector<std::vector<float>> share_;  ///< per region: of each node
  std::shared_ptr<const ContourPaths> paths_;
  std::optional<SwingPaths> swings_;
  std::unique_ptr<const PathTangents> tangents_;  ///< null: paths do not pass on into others
};

}  // namespace slicemorph
