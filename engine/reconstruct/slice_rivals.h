#pragma once

#include "engine/reconstruct/gap_scores.h"

namespace slicemorph {

/// A lead of less than this share of the level is a draw: at one gap of two pixels, a 60th of a pixel.
constexpr float kDraw = 0.01f;

/// What a label's score can be, at every moment.
struct ScoreBounds {
  float low[kMoments], high[kMoments];
};

/// The labels that may win in a cell, on top of those of the cells that hold it.
struct Rivals {
  std::vector<int> labels;          ///< places in the gap's list
  std::vector<ScoreBounds> bounds;  ///< of each
  float most[kMoments] = {};        ///< what one of the last cell's has at least

  bool mayWin(size_t k, size_t moment, float draw) const {
    return bounds[k].high[moment] + draw >= most[moment];
  }
  void cut(size_t size) { labels.resize(size), bounds.resize(size); }

  /// Adds those from `from` on that may win within `reach` of a point of `part`.
  void narrow(const std::vector<GapLabel>& all, size_t from, const PixelBox& part, const Moments& m,
              const PlanePositions& p, float reach);
};

}  // namespace slicemorph
