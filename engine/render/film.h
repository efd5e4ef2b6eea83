#pragma once

#include "engine/render/camera.h"
#include "engine/render/picture.h"
#include "slicemorph/conventions.h"

#include <utility>

namespace slicemorph {

/// Options common to all pictures.
struct RenderOptions {
  int width = 640;         ///< pixels, 1 to 16384
  int height = 480;        ///< pixels, 1 to 16384
  int samples = 4;         ///< rays per pixel where something is visible, 1 to 64
  bool background = true;  ///< false: transparent (alpha 0, colour premultiplied)
  bool channels = false;   ///< also produce mask, depth and normal
  /// Direction in which the key light shines, world; zero: fixed to the camera.
  Vec3d light{0, 0, 0};
  double intensity = 1;  ///< of the key light, 0 or more
};

/// Throws InputError for options out of range.
void checkRenderOptions(const RenderOptions& options);

/// Direction towards the key light, world, unit length.
Vec3d towardsLight(const RenderOptions& options, const ViewBasis& basis);

using Colour = openvdb::Vec3s;

/// What the rays through one pixel met.
struct Pixel {
  Colour colour{0, 0, 0};  ///< premultiplied by the coverage
  float cover = 0;         ///< 0 to 1
  float depth = kFarAway;
  Colour normal{0, 0, 0};
};

/// A picture under construction; pixels may be set from several threads.
class Film {
 public:
  /// Throws as checkRenderOptions and basisOf.
  Film(const Camera& camera, const RenderOptions& options);
  /// Position in the picture of a pixel's n-th ray, -1 to 1, to the right and up.
  openvdb::Vec2d position(int column, int row, int n) const;
  /// Composites the pixel over the background.
  void set(int column, int row, const Pixel& pixel);
  Picture take() { return std::move(picture_); }

 private:
  const RenderOptions& options_;
  Picture picture_;
};

}  // namespace slicemorph
