#pragma once

#include "engine/rebuild/in_between.h"
#include "engine/rebuild/warp_grid.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// The state of a Pullback. "Shape" below is an index into the lattice's objects: several input objects may
/// share one shape.
struct Pullback::Impl {
  Carrying carrying;
  std::optional<size_t> alone;  ///< the object that this in-between equals, if its weight is 1
  Weights weights;              ///< per object, none negative
  /// regions with their own weights; null: weights are the same everywhere
  std::unique_ptr<RegionShares> regions;
  std::vector<size_t> shapeOf;  ///< per object: its shape
  Weights shapeWeights;         ///< per shape
  std::vector<Vec3d> anchors;   ///< per shape
  /// per shape; empty for a pullback without objects' distances
  std::vector<std::shared_ptr<const DistanceField>> fields;
  bool densities = false;     ///< two objects whose densities lie on each other: see flowing_density.h
  std::vector<double> sizes;  ///< per shape: size of the in-between over the object's
  double imageSpacing = 1;    ///< world units between map nodes for images
  std::shared_ptr<const SurfaceMap> surface;  ///< of the same in-between; null: it was not made

  /// Node maps of recently used transforms; the grids of one file mostly share a transform.
  struct Nodes {
    openvdb::math::Transform::ConstPtr transform;
    openvdb::CoordBBox box;
    NodeMap map;
  };
  std::vector<Nodes> nodes;

  /// Whether all objects that count have the in-between's own shape: then nothing moves.
  bool still() const;
  /// Whether the object has a weight other than 0 anywhere.
  bool counts(size_t object) const;
  LocalWeights local() const;
  void refuseRegions() const;
  const NodeMap& nodesFor(const openvdb::CoordBBox& box, const openvdb::math::Transform& transform);
};

}  // namespace slicemorph
