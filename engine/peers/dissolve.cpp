#include "engine/peers/peers.h"
#include "engine/rebuild/pullback.h"

namespace slicemorph {

namespace {

/// Nothing moves, so the map is linear and nodes may be as far apart as single precision allows; world units.
constexpr double kNodeSpacing = 16;

}  // namespace

Pullback dissolve(const Weights& weights) {
  auto pullback = std::make_unique<Pullback::Impl>();
  pullback->alone = aloneIn(weights);
  pullback->weights = withoutNegatives(weights);
  pullback->shapeOf.assign(weights.size(), 0);
  pullback->shapeWeights = {1};
  pullback->anchors = {Vec3d(0.0)};
  pullback->sizes = {1};
  pullback->imageSpacing = kNodeSpacing;
  return Pullback(std::move(pullback));
}

}  // namespace slicemorph
