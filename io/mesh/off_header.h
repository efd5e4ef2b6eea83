#pragma once

#include <string>
#include <string_view>

namespace slicemorph {

/// The first word of an OFF file, `[ST][C][N][4][n]OFF`, and where its counts and body begin.
struct OffHeader {
  bool normals = false, colors = false, texture = false;  ///< what vertices have beside their place
  bool weighted = false;                                  ///< places have a fourth number, which divides them
  bool binary = false;
  std::string_view rest;  ///< what follows the header's words

  int placeNumbers() const { return weighted ? 4 : 3; }
};

/// Parses the header; a file that begins with a number has none, which counts as "OFF". Throws IoError for
/// files that are no OFF or have points in other than three dimensions.
OffHeader readOffHeader(const std::string& path, std::string_view bytes);

}  // namespace slicemorph
