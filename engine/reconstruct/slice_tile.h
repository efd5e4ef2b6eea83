#pragma once

#include "engine/reconstruct/slice_rivals.h"

namespace slicemorph {

constexpr int kTile = 64;  ///< pixels of a cell that is small enough to evaluate every pixel

/// The corner pixels of a tile, carried by the motion.
struct TileCorners {
  float x[4], y[4];

  /// Contains all pixels that are read for points between the corners.
  PixelBox reach() const {
    return {int(std::floor(*std::min_element(x, x + 4))), int(std::floor(*std::min_element(y, y + 4))),
            int(std::ceil(*std::max_element(x, x + 4))) + 1, int(std::ceil(*std::max_element(y, y + 4))) + 1};
  }
};

/// A label's scores at a tile's points, for the four planes one after the other.
struct TileScores {
  std::vector<float> s;
  bool whole = false;  ///< all four planes are read, not only those next to the gap

  void readNear(const GapLabel& l, const Moment& m, const PlanePoints* tile);
  void readFar(const GapLabel& l, const Moment& m, const PlanePoints* tile);
};

/// A cell whose pixels are evaluated one by one. "Half way" is the middle of the gap, where
/// scores are blended.
struct SliceTile {
  PixelBox part, half;            ///< its pixels, and those they come from half way
  TileCorners corners[kMoments];  ///< of its pixels' positions half way, for every moment
  PlanePoints onPlane[4];         ///< the positions of `half` on the four planes
  std::vector<TileScores> scores;
  PlanePoints points;  ///< its pixels' positions half way, at one moment
  std::vector<float> most, blend;
  float best[kTile];
  int winner[kTile];  ///< index in the gap's list

  /// Sets `most` to the largest linearly blended score at moment i, among the rivals from index `from` on.
  void findMost(const Moments& m, size_t i, const Rivals& rivals, size_t from);
  /// Whether a score comes within `spare` of the largest one anywhere in the tile.
  bool comesNear(const TileScores& score, float t, float spare) const;
  /// Sets `blend` to the cubic blend of a label's scores at moment i, for the pixels half way.
  void blendScore(const TileScores& score, const Moments& m, size_t i);
  /// Gives a label the pixels where its blended score exceeds the best one so far by more than `draw`.
  void compete(int label, const int* at, float draw);
};

}  // namespace slicemorph
