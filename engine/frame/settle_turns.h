#pragma once

#include "engine/frame/inner_samples.h"

namespace slicemorph {

/// A turn and how much it distorts inner distances, see innerDistortion.
struct SettledTurn {
  Turn turn;
  double distortion;
};

/// Turns moved to where they distort inner distances least, by few samples of a pair and the best of them by many; those
/// that distort less first. Of turns that are near each other the better one is kept. Nothing depends on how the objects
/// lie in the world, but for where their samples are. `few`, `many`: of the first object and of the second. `starts`: not
/// moved yet, measured by few.
std::vector<SettledTurn> settleTurns(const InnerSamples (&few)[2], const InnerSamples (&many)[2],
                                     const std::vector<SettledTurn>& starts);

}  // namespace slicemorph
