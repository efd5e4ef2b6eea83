#include "io/mesh/picture_texture.h"

#include <tiny_gltf.h>

#include <array>
#include <cmath>
#include <cstring>

namespace slicemorph {
namespace {

/// A texture takes 8 bytes of memory a pixel: 1 GiB.
constexpr std::uint64_t kMostPixels = std::uint64_t(1) << 27;

std::uint64_t numberIn(std::string_view bytes, size_t at, size_t size, bool big) {
  std::uint64_t value = 0;
  for (size_t i = 0; i < size; ++i)
    value = value << 8 | std::uint8_t(at + i < bytes.size() ? bytes[big ? at + i : at + size - 1 - i] : 0);
  return value;
}

/// Width times height of a JPEG, from its frame header (ITU-T T.81, B.2.2); 0: there is none.
std::uint64_t pixelsOfJpeg(std::string_view bytes) {
  for (size_t at = 2; at + 9 < bytes.size();) {
    if (bytes[at] != '\xff') return 0;
    const int marker = std::uint8_t(bytes[at + 1]);
    const bool frame = marker >= 0xc0 && marker <= 0xcf && marker != 0xc4 && marker != 0xc8 && marker != 0xcc;
    if (frame) return numberIn(bytes, at + 5, 2, true) * numberIn(bytes, at + 7, 2, true);
    at += marker == 0xff ? 1 : 2 + numberIn(bytes, at + 2, 2, true);
  }
  return 0;
}

/// Width times height as the file's header says, before anything is allocated. Throws PictureProblem for formats that
/// are not read.
std::uint64_t pixelsOf(std::string_view bytes) {
  const auto begins = [&](std::string_view start) { return bytes.substr(0, start.size()) == start; };
  if (begins("\x89PNG\r\n\x1a\n")) return numberIn(bytes, 16, 4, true) * numberIn(bytes, 20, 4, true);
  if (begins("\xff\xd8\xff")) return pixelsOfJpeg(bytes);
  if (begins("GIF8")) return numberIn(bytes, 6, 2, false) * numberIn(bytes, 8, 2, false);
  if (begins("BM")) {
    const auto side = [&](size_t at) {
      return std::abs(std::int64_t(std::int32_t(numberIn(bytes, at, 4, false))));
    };
    return std::uint64_t(side(18)) * std::uint64_t(side(22));
  }
  // TGA has no mark; these bytes can have few values.
  const auto at = [&](size_t i) { return i < bytes.size() ? int(std::uint8_t(bytes[i])) : -1; };
  const bool kind = (at(2) >= 1 && at(2) <= 3) || (at(2) >= 9 && at(2) <= 11);
  if (kind && at(1) >= 0 && at(1) <= 1 && at(16) >= 8 && at(16) <= 32 && at(16) % 8 == 0)
    return numberIn(bytes, 12, 2, false) * numberIn(bytes, 14, 2, false);
  throw PictureProblem("it is no PNG, JPEG, BMP, GIF or TGA picture");
}

/// IEC 61966-2-1.
double linearOf(double srgb) {
  return srgb <= 0.04045 ? srgb / 12.92 : std::pow((srgb + 0.055) / 1.055, 2.4);
}

std::uint16_t linearTexel(double srgb) { return std::uint16_t(std::lround(linearOf(srgb) * 65535)); }

}  // namespace

std::shared_ptr<const Texture> textureOfPicture(std::string_view bytes, const TextureSampling& sampling) {
  if (bytes.size() > (size_t(1) << 30)) throw PictureProblem("it has more than 1 GiB");
  const std::uint64_t pixels = pixelsOf(bytes);
  if (pixels == 0) throw PictureProblem("it is damaged: it has no size");
  if (pixels > kMostPixels)
    throw PictureProblem("it has " + std::to_string(pixels) + " pixels, at most " +
                         std::to_string(kMostPixels) + " are read");
  tinygltf::Image image;
  std::string problem, ignored;
  const auto* data = reinterpret_cast<const unsigned char*>(bytes.data());
  if (!tinygltf::LoadImageData(&image, 0, &problem, &ignored, 0, 0, data, int(bytes.size()), nullptr))
    throw PictureProblem("it is damaged");
  const size_t channels = size_t(image.component), count = size_t(image.width) * size_t(image.height);
  std::vector<std::uint16_t> texels(3 * count);
  const auto fill = [&](const auto& valueOf) {
    for (size_t i = 0; i < count; ++i)
      for (size_t c = 0; c < 3; ++c) texels[3 * i + c] = valueOf(i * channels + (channels < 3 ? 0 : c));
  };
  if (image.bits == 16) {
    fill([&](size_t i) {
      std::uint16_t value = 0;
      std::memcpy(&value, &image.image[2 * i], sizeof value);
      return linearTexel(value / 65535.0);
    });
  } else {
    std::array<std::uint16_t, 256> table;
    for (size_t v = 0; v < table.size(); ++v) table[v] = linearTexel(double(v) / 255);
    fill([&](size_t i) { return table[image.image[i]]; });
  }
  return std::make_shared<const Texture>(image.width, image.height, std::move(texels), sampling);
}

}  // namespace slicemorph
