#pragma once

#include "engine/rebuild/image_nodes.h"
#include "slicemorph/label_field.h"

namespace slicemorph {

/// A label map of one object, to be carried by the map of its shape.
struct CarriedLabels {
  const LabelField* labels = nullptr;
  size_t shape = 0;       ///< index of the object in the node map
  Vec3d anchor{0, 0, 0};  ///< anchor of that object's distance field, world
  /// times the in-between's size over the object's, so that depths are compared at one scale
  double weight = 0;
};

/// The label with the greatest blended depth at every voxel; see Pullback::carryLabels. Returned as uint8,
/// uint16 or int32, the smallest that holds all labels.
Image warpLabels(const std::vector<CarriedLabels>& labels, const ImageNodes& nodes, const ImageLattice& on);

}  // namespace slicemorph
