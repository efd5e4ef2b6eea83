#pragma once

#include "engine/rebuild/image_nodes.h"
#include "slicemorph/label_field.h"

namespace slicemorph {

/// One object's labels, carried along by the map of its shape.
struct CarriedLabels {
  const LabelField* labels = nullptr;
  size_t shape = 0;       ///< which object of the node map they ride with
  Vec3d anchor{0, 0, 0};  ///< of that object's field
  double weight = 0;      ///< with the object's size against the in-between's: depths count in its units
};

/// The deepest label at every voxel; see Pullback::carryLabels. As uint8, uint16 or int32, whichever holds
/// all.
Image warpLabels(const std::vector<CarriedLabels>& labels, const ImageNodes& nodes, const ImageLattice& on);

}  // namespace slicemorph
