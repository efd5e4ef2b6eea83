#pragma once

#include <array>

namespace slicemorph {

/// Catmull-Rom weights [CR74] of nodes -1, 0, 1, 2 at parameter `a` in [0, 1] between nodes 0 and 1.
inline std::array<double, 4> catmullRomWeights(double a) {
  return {((-0.5 * a + 1) * a - 0.5) * a, (1.5 * a - 2.5) * a * a + 1, ((-1.5 * a + 2) * a + 0.5) * a,
          (0.5 * a - 0.5) * a * a};
}

}  // namespace slicemorph
