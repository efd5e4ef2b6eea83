#include "engine/peers/peers.h"

#include <algorithm>

namespace slicemorph {

SdfBlend::SdfBlend(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize)
    : fields_(levelSets, voxelSize, "sdf") {}

FloatGrid::Ptr SdfBlend::frame(const Weights& weights) const {
  fields_.requireWeights(weights);
  return fields_.levelSetOf([&](const std::vector<const float*>& distances, float* values) {
    std::fill(values, values + FullFields::kLeafValues, 0.0f);
    for (size_t k = 0; k < distances.size(); ++k) {
      const float weight = float(weights[k]);
      for (openvdb::Index i = 0; i < FullFields::kLeafValues; ++i) values[i] += weight * distances[k][i];
    }
  });
}

}  // namespace slicemorph
