#pragma once

#include <vector>

namespace slicemorph {

/// Linear light, first row at the top. Where nothing was met the depth is kFarAway.
struct Picture {
  int width = 0;
  int height = 0;
  /// 4 * width * height: red, green, blue (premultiplied) and alpha; alpha is 1 if the background is drawn.
  std::vector<float> rgba;
  /// The following are width * height long, or empty if not requested.
  std::vector<float> mask = {};  ///< share of the pixel that is covered, with or without a background
  /// World units from the camera's plane along the viewing direction; kFarAway: nothing was met.
  std::vector<float> depth = {};
  std::vector<float> normal = {};  ///< 3 per pixel: world, unit length; zero: nothing was met
};

/// Depth where nothing was met; the value that Blender writes.
constexpr float kFarAway = 1e10f;

}  // namespace slicemorph
