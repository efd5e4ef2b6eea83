#pragma once

#include "engine/frame/align.h"
#include "slicemorph/slicemorph.h"

namespace slicemorph {

/// The distinct shapes among a morph's objects: equal objects share one, which is then measured and matched
/// once.
struct Shapes {
  std::vector<size_t> shapeOf;                 ///< per object
  std::vector<FloatGrid::ConstPtr> levelSets;  ///< per shape, as all below
  std::vector<std::string> names;
  std::vector<size_t> order;  ///< their numbers in the objects' order
  Fields fields;
  std::vector<int> pieces;
  std::vector<Fields> inner;      ///< further surfaces, each per shape; null where one has none
  std::vector<Feature> features;  ///< the options', of the shapes
  std::vector<Region> regions;    ///< the options', of the shapes

  /// The shapes' weights from the objects'. Throws InputError for weights that MorphPlan::frame refuses.
  Weights weightsFrom(const Weights& ofObjects) const;
  /// The shape that an in-between of these weights of the shapes is, if it is one.
  std::optional<size_t> aloneAt(const Weights& weights) const;
  /// Of an in-between of these weights of the shapes, world units; `wanted`: 0: follows the shapes' own.
  double voxelSizeAt(const Weights& weights, double wanted) const;
  /// No in-between has more pieces than the richest of its shapes, small components not counted.
  int piecesAt(const Weights& weights) const;
};

/// Measures the objects' shapes. `before`: of the same objects a moment earlier, null at first: their order is
/// kept, and what is measured of those that are equal.
Shapes measureShapes(const std::vector<Object>& objects, const MorphOptions& options, const Shapes* before);

}  // namespace slicemorph
