#pragma once

#include "engine/rebuild/warp_grid.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// What a Pullback is made of.
struct Pullback::Impl {
  Carrying carrying;
  std::optional<size_t> alone;            ///< the object that the in-between is, if it is one
  Weights weights;                        ///< per object, none below 0
  std::unique_ptr<RegionShares> regions;  ///< with weights per object; null: weights are the same everywhere
  std::vector<size_t> shapeOf;            ///< per object: its position in the lattice
  Weights shapeWeights;                   ///< per position in the lattice
  std::vector<Vec3d> anchors;             ///< per position in the lattice
  std::vector<std::shared_ptr<const DistanceField>> fields;  ///< per position in the lattice; none without one
  std::vector<double> sizes;  ///< per position in the lattice: of the in-between against the object's
  double imageSpacing = 1;    ///< world units between the nodes that carry images

  /// The nodes of the last transforms that were asked for: grids of one file mostly share one.
  struct Nodes {
    openvdb::math::Transform::ConstPtr transform;
    openvdb::CoordBBox box;
    NodeMap map;
  };
  std::vector<Nodes> nodes;

  /// Whether an object's values count anywhere.
  bool counts(size_t object) const;
  LocalWeights local() const;
  void refuseRegions() const;
  const NodeMap& nodesFor(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform);
};

}  // namespace slicemorph
