#pragma once

#include "engine/frame/align.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// The distinct shapes among a morph's objects: equal objects share one, which is then
/// measured and matched once.
struct Shapes {
  std::vector<size_t> shapeOf;                 ///< per object
  std::vector<FloatGrid::ConstPtr> levelSets;  ///< per shape, as all below
  std::vector<std::string> names;
  std::vector<size_t> order;  ///< the shapes' indices in the order in which the objects were given
  Fields fields;
  std::vector<int> pieces;    ///< number of connected components
  std::vector<Fields> inner;  ///< per further surface, one field per shape; null where a shape has none
  std::vector<FloatGrid::ConstPtr> densities;            ///< per shape; null where it is no fog
  std::vector<openvdb::Vec3SGrid::ConstPtr> velocities;  ///< of these; null where there are none
  std::vector<Feature> features;                         ///< the options' features, in terms of the shapes
  std::vector<Region> regions;                           ///< the options' regions, in terms of the shapes

  /// The shapes' weights from the objects'. Throws InputError for weights that MorphPlan::frame rejects.
  Weights weightsFrom(const Weights& ofObjects) const;
  /// The shape that an in-between of these shape weights equals, if there is one.
  std::optional<size_t> aloneAt(const Weights& weights) const;
  /// Voxel size of an in-between of these shape weights, world units. `wanted`: prescribed size, or 0 to
  /// interpolate the shapes' own.
  double voxelSizeAt(const Weights& weights, double wanted) const;
  /// Largest number of pieces among the shapes with a positive weight: an in-between keeps no more than
  /// these, the rest counts as small components.
  int piecesAt(const Weights& weights) const;
};

/// Finds and measures the objects' distinct shapes. `before`: the shapes of the sequence's frame before, null
/// for the first frame; their order is kept, and so are the measurements of unchanged shapes.
Shapes measureShapes(const std::vector<Object>& objects, const MorphOptions& options, const Shapes* before);

}  // namespace slicemorph
