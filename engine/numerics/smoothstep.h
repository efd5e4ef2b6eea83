#pragma once

#include <algorithm>

namespace slicemorph {

/// How far something is taken by what it gains: not at all up to `none`, wholly from `all`, smoothly between.
/// A yes or no would let noise decide between two results.
inline double smoothstep(double gain, double none, double all) {
  const double x = std::min(std::max((gain - none) / (all - none), 0.0), 1.0);
  return x * x * (3 - 2 * x);
}

}  // namespace slicemorph
