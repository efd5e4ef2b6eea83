#pragma once

#include "engine/rebuild/image_nodes.h"
#include "engine/volume/distance_field.h"

#include <optional>

namespace slicemorph {

/// An image of one object, to be carried by the map of its shape.
struct CarriedImage {
  const Image* image = nullptr;
  size_t shape = 0;       ///< index of the object in the node map
  Vec3d anchor{0, 0, 0};  ///< anchor of that object's distance field, world
  double weight = 0;
  const DistanceField* field = nullptr;  ///< of the object; null: depths are not matched
  double size = 1;                       ///< size of the in-between over the object's
  /// Grey value at the object's surface. If all are known, the in-between's surface is kept at
  /// their weighted mean.
  std::optional<double> iso = std::nullopt;
};

/// sum_k w_k V_k(M_k(p)), trilinear, slice by slice; see Pullback::carry. Near a surface each image is
/// sampled where it is as deep inside its object as the voxel is inside the in-between. So thin walls that do
/// not align exactly stay whole, and no ghost of one image's inside appears outside the in-between.
Image warpImages(const std::vector<CarriedImage>& images, const ImageNodes& nodes, const ImageLattice& on);

}  // namespace slicemorph
