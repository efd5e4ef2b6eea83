#pragma once

#include "slicemorph/conventions.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// What is beyond a picture's edges, and how its texels are read.
enum class TextureWrap { kRepeat, kMirror, kClamp };

struct TextureSampling {
  TextureWrap u = TextureWrap::kRepeat, v = TextureWrap::kRepeat;
  bool nearest = false;  ///< texels are squares of one colour; else bilinear between their centres
};

/// A picture that gives a surface its colours: (0, 0) is the corner of its first texel, (1, 1) that of its last.
/// Linear light, 0 to 1.
class Texture {
 public:
  /// `texels`: red, green and blue, row after row, 65535 is 1. Throws InputError where their number does not fit.
  Texture(int width, int height, std::vector<std::uint16_t> texels, const TextureSampling& sampling = {});

  int width() const { return levels_[0].width; }
  int height() const { return levels_[0].height; }

  /// Colour at (u, v). `texels`: size of what one sample stands for; from 2 on, halved pictures are looked up.
  openvdb::Vec3s at(const openvdb::Vec2d& uv, double texels = 1) const;

 private:
  struct Level {
    int width = 0, height = 0;
    std::vector<std::uint16_t> texels;
  };

  openvdb::Vec3s texel(const Level& level, std::int64_t x, std::int64_t y) const;

  std::vector<Level> levels_;  ///< each half as large as the one before
  TextureSampling sampling_;
};

}  // namespace slicemorph
