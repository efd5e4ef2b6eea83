#pragma once

#include "engine/render/picture.h"

#include <string>

namespace slicemorph {

struct Tile {
  Picture image;
  std::string caption;  ///< ASCII, such as "t=0.25"; cut off at the tile's width
};

/// One picture made of many: tiles row by row with thin gaps, each with its caption in the lower left corner.
/// `columns` 0 chooses a nearly square number of tiles, rather wider than high. Throws InputError for no
/// tiles, tiles of different sizes or negative `columns`.
Picture contactSheet(const std::vector<Tile>& tiles, int columns = 0);

}  // namespace slicemorph
