#include "io/image/display_pixels.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Linear light to an 8-bit sRGB code value (IEC 61966-2-1, whose numbers these are).
std::uint8_t encode(float linear) {
  const float v = std::clamp(std::isnan(linear) ? 0.0f : linear, 0.0f, 1.0f);
  const float coded = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  return std::uint8_t(std::lround(255 * coded));
}

}  // namespace

std::vector<std::uint8_t> displayPixels(const Picture& image, bool alpha) {
  const size_t bytes = alpha ? 4 : 3, width = size_t(image.width);
  std::vector<std::uint8_t> pixels(bytes * width * size_t(image.height));
  tbb::parallel_for(0, image.height, [&](int row) {
    for (size_t n = size_t(row) * width; n < size_t(row + 1) * width; ++n) {
      const float* from = &image.rgba[4 * n];
      const float share = alpha ? from[3] : 1.0f;
      for (size_t c = 0; c < 3; ++c) pixels[bytes * n + c] = encode(share > 0 ? from[c] / share : 0.0f);
      if (alpha) pixels[bytes * n + 3] = std::uint8_t(std::lround(255 * std::clamp(share, 0.0f, 1.0f)));
    }
  });
  return pixels;
}

}  // namespace slicemorph
