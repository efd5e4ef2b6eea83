#pragma once

#include "engine/rebuild/image_nodes.h"
#include "engine/volume/distance_field.h"

#include <optional>

namespace slicemorph {

/// One object's image, carried along by the map of its shape.
struct CarriedImage {
  const Image* image = nullptr;
  size_t shape = 0;       ///< which object of the node map it rides with
  Vec3d anchor{0, 0, 0};  ///< of that object's field
  double weight = 0;
  const DistanceField* field = nullptr;  ///< of the object; null: positions alone are matched, not depths
  double size = 1;                       ///< of the in-between against the object
  /// The value at its surface; where all are known the in-between's surface has their blend.
  std::optional<double> iso = std::nullopt;
};

/// sum_k w_k V_k(M_k(p)), trilinear, slice by slice; see Pullback::carry. Near the surfaces every image is
/// looked up where it is as deep inside its object as the in-between is, along the way to its surface: thin
/// walls that do not lie quite on each other stay whole, and what is outside the in-between shows no ghost of
/// one image's inside.
Image warpImages(const std::vector<CarriedImage>& images, const ImageNodes& nodes, const ImageLattice& on);

}  // namespace slicemorph
