#include "io/png_writer.h"

#include "engine/errors.h"
#include "io/atomic_file.h"

#include <png.h>

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

/// Linear to sRGB (IEC 61966-2-1), 8 bits.
png_byte encode(float linear) {
  const float v = std::clamp(std::isnan(linear) ? 0.0f : linear, 0.0f, 1.0f);
  const float coded = v <= 0.0031308f ? 12.92f * v : 1.055f * std::pow(v, 1 / 2.4f) - 0.055f;
  return png_byte(std::lround(255 * coded));
}

std::vector<png_byte> pixelsOf(const Picture& image, bool opaque) {
  std::vector<png_byte> pixels;
  pixels.reserve(image.rgba.size());
  for (size_t n = 0; n < image.rgba.size(); n += 4) {
    const float alpha = opaque ? 1.0f : image.rgba[n + 3];
    for (size_t c = 0; c < 3; ++c) pixels.push_back(encode(alpha > 0 ? image.rgba[n + c] / alpha : 0.0f));
    if (!opaque) pixels.push_back(png_byte(std::lround(255 * std::clamp(alpha, 0.0f, 1.0f))));
  }
  return pixels;
}

bool isOpaque(const Picture& image) {
  for (size_t n = 3; n < image.rgba.size(); n += 4) {
    if (image.rgba[n] < 1) return false;
  }
  return true;
}

}  // namespace

std::string encodePng(const Picture& image) {
  const bool opaque = isOpaque(image);
  const std::vector<png_byte> pixels = pixelsOf(image, opaque);
  png_image header = {};
  header.version = PNG_IMAGE_VERSION;
  header.width = png_uint_32(image.width);
  header.height = png_uint_32(image.height);
  header.format = opaque ? PNG_FORMAT_RGB : PNG_FORMAT_RGBA;
  std::string file(PNG_IMAGE_PNG_SIZE_MAX(header), '\0');
  png_alloc_size_t size = file.size();
  if (!png_image_write_to_memory(&header, file.data(), &size, 0, pixels.data(), 0, nullptr)) {
    throw IoError(std::string("a PNG cannot be made: ") + header.message);
  }
  file.resize(size);
  return file;
}

void writePng(const std::string& path, const Picture& image) {
  const std::string file = encodePng(image);
  AtomicFile output(path);
  output.write(file);
  output.commit();
}

}  // namespace slicemorph
