#pragma once

#include "engine/numerics/pixel_box.h"

#include <cstdint>
#include <vector>

namespace slicemorph {

/// The pixels [x0, x1) of one row that have one label and belong to one piece.
struct PieceRun {
  int y, x0, x1, label;
  std::uint32_t piece;  ///< index of the piece's first run
};

/// Which pixels of a label hang together.
enum class Touching { kSides, kCorners };

/// A slice's runs of equal labels, row by row, from left to right; each run is a piece.
std::vector<PieceRun> findRuns(const PixelBox& domain, const int* slice);

/// Joins the runs of a slice to pieces.
void joinToPieces(std::vector<PieceRun>& runs, Touching touching);

}  // namespace slicemorph
