#pragma once

#include <openvdb/math/Mat4.h>

#include <optional>
#include <vector>

namespace slicemorph {

/// Where a picture was taken from, for programs that take it on: (x, y, z, 1) * matrix, divided by its last component.
struct ViewMatrices {
  openvdb::Mat4d worldToCamera;  ///< left-handed: x right, y up, z forward from the camera
  openvdb::Mat4d worldToScreen;  ///< -1 to 1 across the picture, x to the right, y up; z grows with depth
};

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
  std::vector<float> normal = {};         ///< 3 per pixel: world, unit length; zero: nothing was met
  std::optional<ViewMatrices> view = {};  ///< nothing: put together from several
};

/// Depth where nothing was met; the value that Blender writes.
constexpr float kFarAway = 1e10f;

}  // namespace slicemorph
