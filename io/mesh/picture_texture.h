#pragma once

#include "engine/volume/texture.h"

#include <memory>
#include <stdexcept>
#include <string>
#include <string_view>

namespace slicemorph {

/// A picture that cannot be used; the message completes "its texture X is left out:".
struct PictureProblem : std::runtime_error {
  using std::runtime_error::runtime_error;
};

/// Decodes a picture (PNG, JPEG, BMP, GIF or TGA) as a texture: sRGB becomes linear light, transparency counts for
/// nothing. Throws PictureProblem for other and damaged files and for more than 2^27 pixels.
std::shared_ptr<const Texture> textureOfPicture(std::string_view bytes, const TextureSampling& sampling);

}  // namespace slicemorph
