#include "io/image/png_writer.h"

#include "io/atomic_file.h"
#include "io/image/display_pixels.h"
#include "slicemorph/errors.h"

#include <png.h>

namespace slicemorph {
namespace {

bool isOpaque(const Picture& image) {
  for (size_t n = 3; n < image.rgba.size(); n += 4) {
    if (image.rgba[n] < 1) return false;
  }
  return true;
}

}  // namespace

std::string encodePng(const Picture& image) {
  const bool opaque = isOpaque(image);
  const std::vector<std::uint8_t> pixels = displayPixels(image, !opaque);
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
