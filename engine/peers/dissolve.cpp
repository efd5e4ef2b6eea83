#include "engine/peers/peers.h"
#include "engine/rebuild/carrier.h"

namespace slicemorph {

Carrier dissolve(const Weights& weights) {
  auto carrier = std::make_unique<Carrier::Impl>();
  carrier->weights = weights;
  carrier->shapeOf.assign(weights.size(), 0);
  carrier->shapeWeights = {1};
  carrier->anchors = {Vec3d(0.0)};
  return Carrier(std::move(carrier));
}

}  // namespace slicemorph
