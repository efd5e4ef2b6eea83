#pragma once

#include "engine/spine/chart.h"

namespace slicemorph {

/// A state, which has a `rotation`, moved by coordinate ascent over small turns about three axes, from steps of `coarse`
/// to steps of more than `fine` radians. `at(rotation)` makes the state there; `score(state)` is to grow, by more than
/// `gain(state, step)` for another move.
template <typename State, typename At, typename Score, typename Gain>
State climbRotation(State best, double coarse, double fine, const At& at, const Score& score,
                    const Gain& gain) {
  for (double step = coarse; step > fine; step *= 0.5)
    for (bool moved = true; moved;) {
      // Take the best of the six neighbours, not the first, so that the ascent is the same from b to a.
      const Mat3d half = rotationFromVector(0.5 * rotationVector(best.rotation));
      State next = best;
      for (int axis = 0; axis < 6; ++axis) {
        Vec3d v(0.0);
        v[axis / 2] = axis % 2 ? -step : step;
        const State neighbour = at(half * rotationFromVector(v) * half);
        if (score(neighbour) > score(next)) next = neighbour;
      }
      moved = score(next) > score(best) + gain(best, step);
      if (moved) best = next;
    }
  return best;
}

}  // namespace slicemorph
