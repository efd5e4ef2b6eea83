#include "engine/volume/texture.h"

#include "slicemorph/errors.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {
namespace {

constexpr double kTexelOne = 65535;

/// The texel that lies at `i` where the picture has `n` and goes on beyond its edges.
std::int64_t wrapped(std::int64_t i, std::int64_t n, TextureWrap wrap) {
  if (wrap == TextureWrap::kClamp) return std::clamp<std::int64_t>(i, 0, n - 1);
  const std::int64_t period = wrap == TextureWrap::kMirror ? 2 * n : n;
  const std::int64_t rest = (i % period + period) % period;
  return rest < n ? rest : period - 1 - rest;
}

/// Coordinates so large that texels cannot be counted mean nothing.
double countable(double x) {
  constexpr double kMost = 1e9;
  return std::isfinite(x) ? std::clamp(x, -kMost, kMost) : 0;
}

}  // namespace

Texture::Texture(int width, int height, std::vector<std::uint16_t> texels, const TextureSampling& sampling)
    : sampling_(sampling) {
  if (width < 1 || height < 1 || texels.size() != 3 * size_t(width) * size_t(height))
    throw InputError("a texture of " + std::to_string(width) + " by " + std::to_string(height) + " has " +
                     std::to_string(texels.size()) + " numbers");
  levels_.push_back({width, height, std::move(texels)});
  while (levels_.back().width > 1 || levels_.back().height > 1) {
    const Level& from = levels_.back();
    Level to{std::max(1, from.width / 2), std::max(1, from.height / 2), {}};
    to.texels.reserve(3 * size_t(to.width) * size_t(to.height));
    for (int y = 0; y < to.height; ++y)
      for (int x = 0; x < to.width; ++x) {
        // All texels whose share of the picture it is: two by two, or three where the size is odd.
        const int x0 = int(std::int64_t(x) * from.width / to.width),
                  x1 = int(std::int64_t(x + 1) * from.width / to.width);
        const int y0 = int(std::int64_t(y) * from.height / to.height),
                  y1 = int(std::int64_t(y + 1) * from.height / to.height);
        for (int c = 0; c < 3; ++c) {
          std::uint32_t sum = 0, count = 0;
          for (int j = y0; j < y1; ++j)
            for (int i = x0; i < x1; ++i, ++count)
              sum += from.texels[3 * (size_t(j) * size_t(from.width) + size_t(i)) + size_t(c)];
          to.texels.push_back(std::uint16_t((sum + count / 2) / count));
        }
      }
    levels_.push_back(std::move(to));
  }
}

openvdb::Vec3s Texture::texel(const Level& level, std::int64_t x, std::int64_t y) const {
  const size_t i = size_t(wrapped(x, level.width, sampling_.u)),
               j = size_t(wrapped(y, level.height, sampling_.v));
  const std::uint16_t* rgb = &level.texels[3 * (j * size_t(level.width) + i)];
  return openvdb::Vec3s(float(rgb[0]), float(rgb[1]), float(rgb[2]));
}

openvdb::Vec3s Texture::at(const openvdb::Vec2d& uv, double texels) const {
  size_t index = 0;
  for (; texels >= 2 && index + 1 < levels_.size(); texels /= 2) ++index;
  const Level& level = levels_[index];
  const double x = countable(uv[0] * level.width), y = countable(uv[1] * level.height);
  if (sampling_.nearest && index == 0)
    return texel(level, std::int64_t(std::floor(x)), std::int64_t(std::floor(y))) / float(kTexelOne);
  const double left = std::floor(x - 0.5), top = std::floor(y - 0.5);
  const double right = x - 0.5 - left, down = y - 0.5 - top;
  const auto i = std::int64_t(left), j = std::int64_t(top);
  const Vec3d above = Vec3d(texel(level, i, j)) * (1 - right) + Vec3d(texel(level, i + 1, j)) * right;
  const Vec3d below = Vec3d(texel(level, i, j + 1)) * (1 - right) + Vec3d(texel(level, i + 1, j + 1)) * right;
  return openvdb::Vec3s((above * (1 - down) + below * down) / kTexelOne);
}

}  // namespace slicemorph
