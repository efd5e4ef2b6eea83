#pragma once

#include <algorithm>

namespace slicemorph {

/// Cubic smoothstep: 0 up to `none`, 1 from `all` on. Used for how much of a result is taken, given what it
/// gains: a hard threshold would let noise decide between two results.
inline double smoothstep(double gain, double none, double all) {
  const double x = std::min(std::max((gain - none) / (all - none), 0.0), 1.0);
  return x * x * (3 - 2 * x);
}

}  // namespace slicemorph
