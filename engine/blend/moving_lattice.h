#pragma once

#include "engine/blend/contour_paths.h"
#include "engine/blend/local_weights.h"

#include <functional>
#include <optional>

namespace slicemorph {

/// How much faster than a distance the blend of the objects' distances may change.
constexpr double kSteepest = 1.3;

/// Vectors at the nodes of a coarse grid over a frame's voxels; for the backward map of an in-between where
/// each node lies on every object. Nodes far from the in-between surface are not known.
struct NodeMap {
  int step = 4;                    ///< voxels between nodes; node (i, j, k) is voxel step * (i, j, k)
  openvdb::Coord origin{0, 0, 0};  ///< first node
  openvdb::Coord size{0, 0, 0};
  size_t objects = 0;
  std::vector<openvdb::Vec3s>
      at;                    ///< per node and object: a place in the world is relative to the field's anchor
  std::vector<char> known;   ///< per node
  std::vector<double> jump;  ///< per object: places of neighbours further apart lie on crossing slices
  double foldShare = 0;      ///< share of the surface's cells whose Jacobian to some object is below 0.05

  size_t index(int i, int j, int k) const {
    return (size_t(k - origin[2]) * size[1] + (j - origin[1])) * size[0] + (i - origin[0]);
  }
  bool inside(int i, int j, int k) const {
    return i >= origin[0] && j >= origin[1] && k >= origin[2] && i < origin[0] + size[0] &&
           j < origin[1] + size[1] && k < origin[2] + size[2];
  }
};

/// The matching's lattice, made to move: its nodes have a place on every object and so on every in-between.
/// Between the nodes the map is linear on tetrahedra; without folds it is one to one, and its inverse exact.
class MovingLattice {
 public:
  /// `regions`: of the objects; none: weights are the same everywhere. `paths`: null: points go straight on.
  MovingLattice(const Displacements& map, const Fields& fields, const std::vector<Chart>& charts,
                std::shared_ptr<const RegionShares> regions = nullptr,
                std::shared_ptr<const ContourPaths> paths = nullptr);

  /// One in-between's places of the lattice nodes.
  struct Pose {
    Chart chart;            ///< blended, and bent ones moved so that the centroid travels straight
    Weights mean;           ///< of the objects: where regions have weights of their own, of the whole inside
    std::vector<Vec3d> at;  ///< per node: chart coordinates
    std::vector<Vec3d> world;     ///< per node
    std::vector<float> distance;  ///< per node: blended, chart units
    int straightening = 0;  ///< rounds that borders were widened, or ways straightened, lest anything folds
  };
  Pose poseAt(const Weights& weights) const;
  /// Of an object itself, whatever regions say.
  Pose poseOf(size_t object) const;
  /// The weights at each place of such an in-between.
  LocalWeights localWeights(const Weights& weights) const { return {weights, regions_.get()}; }
  /// Where what one in-between has at some world points is on another one.
  std::vector<Vec3d> carryPoints(const std::vector<Vec3d>& points, const Pose& from, const Pose& to) const;

  /// `transform`: index space of the frame. Parallel; the same for any thread count.
  NodeMap nodesNearSurface(const Pose& pose, const openvdb::math::Transform& transform, int step) const;
  /// Where what an object has in a box of the world lies on the in-between: a box of index space.
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
  /// Per node and object; empty where weights are the same everywhere.
  using NodeWeights = std::vector<float>;
  NodeWeights nodeWeights(const Weights& weights) const;
  NodeWeights smoothed(const NodeWeights& weights) const;
  /// `offsets`: per node, chart units; none where points go straight on.
  Pose blend(const Weights& weights, const NodeWeights& local, const VectorField& offsets) const;
  Pose poseAt(const Weights& weights, std::optional<int> straightening) const;
  Pose blendUnfolded(const Weights& weights, const NodeWeights& local,
                     std::optional<int> straightening) const;
  bool folds(const Pose& pose, const NodeWeights& local) const;
  void layAlongSpine(const NodeWeights& local, Pose& pose) const;
  Vec3d centroid(const Pose& pose, const Chart& chart) const;
  VectorField displacementOf(const Pose& pose) const;
  struct Frame;
  struct Found;
  /// What the nodes of a map have at a chart point beyond the lattice.
  using Beyond = std::function<openvdb::Vec3s(const Vec3d& q, size_t field)>;
  Frame frameOf(const Pose& pose, const openvdb::math::Transform& transform,
                std::vector<const VectorField*> fields, NodeMap& map) const;
  std::vector<const VectorField*> places() const;
  std::vector<double> jumps(const Chart& chart, const openvdb::math::Transform& transform, int step) const;
  void findNodes(const Frame& frame, NodeMap& map) const;
  void fillBox(const openvdb::CoordBBox& box, Frame frame, const openvdb::math::Transform& transform,
               const Beyond& beyond, NodeMap& map) const;
  void rasterise(const Frame& frame, int z, Found& found) const;
  bool endsWithin(float distance, const Pose& pose) const;
  void continueBeyond(const Pose& pose, const openvdb::math::Transform& transform, float reach,
                      NodeMap& map) const;

  Lattice lattice_;
  std::vector<Chart> charts_;
  size_t objects_;
  std::vector<Vec3d> anchor_;                 ///< per object: its field's
  std::vector<VectorField> chart_;            ///< per object: chart coordinates of the nodes
  std::vector<VectorField> place_;            ///< per object: world, relative to the field's anchor
  std::vector<std::vector<float>> distance_;  ///< per object: distance at the nodes, chart units
  std::vector<Vec3d> centroid_;               ///< per object, by centroid(); where charts are bent
  std::shared_ptr<const RegionShares> regions_;
  std::vector<std::vector<float>> share_;  ///< per region: of each node
  std::shared_ptr<const ContourPaths> paths_;
};

}  // namespace slicemorph
