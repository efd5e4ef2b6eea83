#include "engine/peers/morphology.h"

#include "slicemorph/errors.h"

#include <algorithm>

namespace slicemorph {

MorphologyMorph::MorphologyMorph(const std::vector<FloatGrid::ConstPtr>& levelSets, double voxelSize,
                                 Progress* progress)
    : fields_(levelSets, voxelSize, "morphology", progress) {
  const FloatGrid::Ptr common =
      fields_.levelSetOf([](const std::vector<const float*>& distances, float* values) {
        std::copy(distances[0], distances[0] + FullFields::kLeafValues, values);
        for (size_t k = 1; k < distances.size(); ++k)
          for (openvdb::Index i = 0; i < FullFields::kLeafValues; ++i)
            values[i] = std::max(values[i], distances[k][i]);
      });
  reportOrCancel(progress, "measuring distances", 1);
  bool any = false;
  for (auto value = common->cbeginValueOn(); value && !any; ++value) any = *value < 0;
  if (!any)
    throw InputError(
        "--method morphology grows and shrinks objects out of the part that all have in common; these have "
        "none: lay them on each other or use another method, such as --method slices");
  fields_.add(common);
}

FloatGrid::Ptr MorphologyMorph::frame(const Weights& weights) const {
  fields_.requireWeights(weights);
  return fields_.levelSetOf([&](const std::vector<const float*>& distances, float* values) {
    const float* common = distances.back();
    for (size_t k = 0; k < weights.size(); ++k) {
      const float weight = float(weights[k]), rest = float(1 - weights[k]);
      for (openvdb::Index i = 0; i < FullFields::kLeafValues; ++i) {
        const float value = weight * distances[k][i] + rest * common[i];
        values[i] = k == 0 ? value : std::min(values[i], value);
      }
    }
  });
}

}  // namespace slicemorph
