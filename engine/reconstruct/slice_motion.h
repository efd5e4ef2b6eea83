#pragma once

#include "engine/reconstruct/score_field.h"

namespace slicemorph {

/// A smooth displacement in the plane from one plane to the next, in pixels, on nodes `spacing` pixels apart.
struct SliceMotion {
  float origin[2] = {0, 0}, spacing[2] = {1, 1};
  int nx = 0, ny = 0;  ///< number of nodes; 0: no motion
  std::vector<float> x, y;

  struct Vector {
    float x, y;
  };
  Vector at(float px, float py) const {
    if (x.empty()) return {0, 0};
    const float gx = std::min(std::max((px - origin[0]) / spacing[0], 0.0f), float(nx - 1));
    const float gy = std::min(std::max((py - origin[1]) / spacing[1], 0.0f), float(ny - 1));
    const int ix = std::min(int(gx), nx - 2), iy = std::min(int(gy), ny - 2);
    const float fx = gx - float(ix), fy = gy - float(iy);
    const size_t i = size_t(iy) * size_t(nx) + size_t(ix), j = i + size_t(nx);
    const auto mix = [&](const std::vector<float>& v) {
      const float low = v[i] + fx * (v[i + 1] - v[i]), high = v[j] + fx * (v[j + 1] - v[j]);
      return low + fy * (high - low);
    };
    return {mix(x), mix(y)};
  }
};

/// The motion that carries the labels of plane `a` onto those of the next, as a function of position half way
/// between the planes. Least squares on the differences of the labels' distances, over windows that shrink
/// from coarse to fine ([LK81], all labels at once, so that neighbours move together). Symmetric: the motion
/// from b to a is its negative.
SliceMotion findMotion(const ScoreStack& stack, size_t a);

}  // namespace slicemorph
