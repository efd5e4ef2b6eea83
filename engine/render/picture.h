#pragma once

#include <vector>

namespace slicemorph {

/// Linear light, first row on top. What lies behind is one value of depth, too: far away.
struct Picture {
  int width = 0;
  int height = 0;
  /// 4 * width * height: red, green, blue (premultiplied) and alpha; alpha is 1 where the background is
  /// drawn.
  std::vector<float> rgba;
  /// width * height each, or empty: made only when asked for.
  std::vector<float> mask = {};  ///< share of the pixel that is covered, with or without a background
  std::vector<float> depth =
      {};  ///< world units from the camera's plane along the axis of view; kFarAway: nothing
  std::vector<float> normal = {};  ///< 3 a pixel: world, unit length; zero: nothing
};

/// The depth of nothing, as Blender writes it.
constexpr float kFarAway = 1e10f;

}  // namespace slicemorph
