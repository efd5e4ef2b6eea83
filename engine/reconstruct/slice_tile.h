#pragma once

#include "engine/reconstruct/slice_rivals.h"

namespace slicemorph {

constexpr int kTile = 64;  ///< pixels of a cell that is not cut any further

/// Corners of a tile's pixels, carried.
struct TileCorners {
  float x[4], y[4];

  /// Holds all pixels that are read between the corners.
  PixelBox reach() const {
    return {int(std::floor(*std::min_element(x, x + 4))), int(std::floor(*std::min_element(y, y + 4))),
            int(std::ceil(*std::max_element(x, x + 4))) + 1, int(std::ceil(*std::max_element(y, y + 4))) + 1};
  }
};

/// A label's scores of a tile's points on the four planes, one after the other.
struct TileScores {
  std::vector<float> s;
  bool whole = false;  ///< not only those next to the gap

  void readNear(const GapLabel& l, const Moment& m, const PlanePoints* tile);
  void readFar(const GapLabel& l, const Moment& m, const PlanePoints* tile);
};

/// A cell whose pixels are looked at one by one.
struct SliceTile {
  PixelBox part, half;            ///< its pixels, and those that they come from half way
  TileCorners corners[kMoments];  ///< of its pixels half way, at every moment
  PlanePoints onPlane[4];         ///< the pixels of `half`
  std::vector<TileScores> scores;
  PlanePoints points;  ///< its pixels at one moment
  std::vector<float> most, blend;
  float best[kTile];
  int winner[kTile];  ///< place in the gap's list

  /// The greatest score on the way from plane to plane, of all rivals from `from` on.
  void findMost(const Moments& m, size_t i, const Rivals& rivals, size_t from);
  /// Whether a score comes within `spare` of the greatest anywhere.
  bool comesNear(const TileScores& score, float t, float spare) const;
  /// A score at one moment, of the pixels half way.
  void blendScore(const TileScores& score, const Moments& m, size_t i);
  /// Gives a label the pixels where its blended score beats the best one.
  void compete(int label, const int* at, float draw);
};

}  // namespace slicemorph
