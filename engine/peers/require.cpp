#include "engine/peers/require.h"

#include "engine/numerics/readable.h"
#include "slicemorph/errors.h"

namespace slicemorph {

void requireWeights(const Weights& weights, size_t objects) {
  if (weights.size() != objects)
    throw InputError(std::to_string(weights.size()) + " weights for " + std::to_string(objects) + " objects");
}

void requireAtMost(const std::string& needs, double count, double most) {
  if (!(count <= most))
    throw InputError(needs + readableCount(count) + " here; " + readableCount(most) +
                     " at most: choose a larger --voxel-size or a smaller --resolution");
}

}  // namespace slicemorph
