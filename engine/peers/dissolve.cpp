#include "engine/peers/peers.h"
#include "engine/rebuild/carrier.h"

namespace slicemorph {

namespace {

/// Nothing moves, so nodes may lie as far apart as single precision allows; world units.
constexpr double kNodeSpacing = 16;

}  // namespace

Carrier dissolve(const Weights& weights) {
  auto carrier = std::make_unique<Carrier::Impl>();
  carrier->alone = aloneIn(weights);
  carrier->weights = withoutNegatives(weights);
  carrier->shapeOf.assign(weights.size(), 0);
  carrier->shapeWeights = {1};
  carrier->anchors = {Vec3d(0.0)};
  carrier->sizes = {1};
  carrier->imageSpacing = kNodeSpacing;
  return Carrier(std::move(carrier));
}

}  // namespace slicemorph
