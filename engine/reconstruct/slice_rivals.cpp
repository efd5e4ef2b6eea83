#include "engine/reconstruct/slice_rivals.h"

namespace slicemorph {

namespace {

/// Bounds of a label's score within `reach` of a point.
ScoreBounds boundsOf(const GapLabel& l, const Moments& m, const PlanePositions& p, float reach) {
  float s[4], lo[4], hi[4];
  readScores(l, p, s);
  for (int k = 0; k < 4; ++k) lo[k] = s[k] - reach, hi[k] = s[k] + reach;
  completeScores(l, m.first, lo), completeScores(l, m.first, hi);
  const float spare = 1e-4f * m.first.level;  // so that rounding rules out no winner
  ScoreBounds b;
  for (size_t i = 0; i < kMoments; ++i) {
    float low = 0, high = 0;
    for (int k = 0; k < 4; ++k) {
      const float c = m.cubic[k][i];
      low += c * (c > 0 ? lo[k] : hi[k]), high += c * (c > 0 ? hi[k] : lo[k]);
    }
    b.low[i] = limited(low, lo[1] + m.t[i] * (lo[2] - lo[1]), m.limit[i]) - spare;
    b.high[i] = limited(high, hi[1] + m.t[i] * (hi[2] - hi[1]), m.limit[i]);
  }
  return b;
}

}  // namespace

void Rivals::narrow(const std::vector<GapLabel>& all, size_t from, const PixelBox& part, const Moments& m,
                    const PlanePositions& p, float reach) {
  const size_t end = labels.size();
  std::fill_n(most, kMoments, -1e30f);
  // Where no label's box overlaps the cell, all of them compete.
  for (int anywhere = 0; anywhere < 2 && labels.size() == end; ++anywhere)
    for (size_t k = from; k < end; ++k) {
      const GapLabel& l = all[size_t(labels[k])];
      if (!anywhere && intersection(l.box, part).empty()) continue;
      const ScoreBounds b = boundsOf(l, m, p, reach);
      for (size_t i = 0; i < kMoments; ++i) most[i] = std::max(most[i], b.low[i]);
      labels.push_back(labels[k]), bounds.push_back(b);
    }
  size_t kept = end;
  const float draw = m.first.draw;
  for (size_t k = end; k < labels.size(); ++k) {
    bool may = false;
    for (size_t i = 0; i < m.count; ++i) may = may || mayWin(k, i, draw);
    if (may) labels[kept] = labels[k], bounds[kept++] = bounds[k];
  }
  cut(kept);
}

}  // namespace slicemorph
