#pragma once

#include "engine/render/picture.h"

#include <string>

namespace slicemorph {

struct Tile {
  Picture image;
  std::string caption;  ///< ASCII, for example "t=0.25"; what does not fit the tile's width is cut off
};

/// One picture of many: tiles row by row, each with its caption in its lower left corner, thin gaps between.
/// `columns` 0 chooses a sheet about as wide as high in tiles, wider rather than higher.
/// Throws InputError for no tiles, tiles of different sizes or a negative `columns`.
Picture contactSheet(const std::vector<Tile>& tiles, int columns = 0);

}  // namespace slicemorph
