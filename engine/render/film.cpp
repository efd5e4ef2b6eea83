#include "engine/render/film.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

constexpr int kMostPixels = 16384, kMostSamples = 64;

/// Background: darker at the top, lighter at the bottom, slightly darker in the corners. `x`, `y` in -1..1.
Colour backgroundAt(double x, double y) {
  const float t = float(0.5 - 0.5 * y);
  const float smooth = t * t * (3 - 2 * t);
  const float grey = (0.045f + 0.215f * smooth) * float(1 - 0.12 * (x * x + 0.5 * y * y));
  return Colour(grey * 0.97f, grey, grey * 1.04f);
}

}  // namespace

void checkRenderOptions(const RenderOptions& options) {
  for (const int side : {options.width, options.height}) {
    if (side < 1 || side > kMostPixels) {
      throw InputError("picture size " + std::to_string(options.width) + " x " +
                       std::to_string(options.height) + ": width and height must be 1 to 16384 pixels");
    }
  }
  if (options.samples < 1 || options.samples > kMostSamples)
    throw InputError("samples " + std::to_string(options.samples) + ": must be 1 to 64 a pixel");
  if (!(options.intensity >= 0) || !std::isfinite(options.intensity))
    throw InputError("light intensity " + std::to_string(options.intensity) + ": must be 0 or more");
}

Vec3d towardsLight(const RenderOptions& options, const ViewBasis& basis) {
  return options.light.lengthSqr() > 0 ? -options.light.unit() : basis.toWorld(Vec3d(-0.8, 0.75, 0.5).unit());
}

Film::Film(const Camera& camera, const RenderOptions& options) : options_(options) {
  checkRenderOptions(options);
  picture_.view = viewMatrices(camera, double(options.width) / options.height);
  const size_t pixels = size_t(options.width) * size_t(options.height);
  picture_.width = options.width, picture_.height = options.height;
  picture_.rgba.resize(4 * pixels);
  if (!options.channels) return;
  picture_.mask.resize(pixels);
  picture_.depth.resize(pixels);
  picture_.normal.resize(3 * pixels);
}

openvdb::Vec2d Film::position(int column, int row, int n) const {
  const openvdb::Vec2d at = samplePosition(n);
  return {2 * (column + at.x()) / options_.width - 1, 1 - 2 * (row + at.y()) / options_.height};
}

void Film::set(int column, int row, const Pixel& pixel) {
  const size_t n = size_t(row) * size_t(options_.width) + size_t(column);
  Colour colour = pixel.colour;
  float alpha = pixel.cover;
  if (options_.background) {
    const openvdb::Vec2d middle = position(column, row, 0);
    colour += backgroundAt(middle.x(), middle.y()) * (1 - pixel.cover);
    alpha = 1;
  }
  std::copy_n(colour.asPointer(), 3, &picture_.rgba[4 * n]);
  picture_.rgba[4 * n + 3] = alpha;
  if (!options_.channels) return;
  picture_.mask[n] = pixel.cover;
  picture_.depth[n] = pixel.depth;
  std::copy_n(pixel.normal.asPointer(), 3, &picture_.normal[3 * n]);
}

}  // namespace slicemorph
