#pragma once

#include "engine/reconstruct/gap_scores.h"

namespace slicemorph {

/// Bounds of a label's score at every moment.
struct ScoreBounds {
  float low[kMoments], high[kMoments];
};

/// A stack of labels that may win in a cell; those of the enclosing cells are further down.
struct Rivals {
  std::vector<int> labels;          ///< indices in the gap's list
  std::vector<ScoreBounds> bounds;  ///< of each label
  float most[kMoments] = {};        ///< the largest lower bound among the last cell's labels

  bool mayWin(size_t k, size_t moment, float draw) const {
    return bounds[k].high[moment] + draw >= most[moment];
  }
  void cut(size_t size) { labels.resize(size), bounds.resize(size); }

  /// Pushes those of the labels from index `from` on that may win within `reach` (world units) of the centre
  /// of `part`.
  void narrow(const std::vector<GapLabel>& all, size_t from, const PixelBox& part, const Moments& m,
              const PlanePositions& p, float reach);
};

}  // namespace slicemorph
