#pragma once

#include "engine/reconstruct/slice_scores.h"

#include <algorithm>
#include <cmath>

namespace slicemorph {

/// How a path through a gap bends at a moment, by the gaps beyond the gap's planes; 0 where there are none.
struct PathBend {
  float weight[2] = {
      0, 0};  ///< of the difference between the motion over the gap before, after, and that over this one
  float ratio[2] = {0, 0};  ///< length of this gap to that of the one before, after
};

/// A position along the stack: its gap, the fraction of the gap, and the weights of the four planes' scores.
struct Moment {
  size_t gap = 0;
  float t = 0;
  float cubic[4] = {0, 0, 0, 0};
  float limit = 0;  ///< largest allowed difference of the cubic from the linear blend
  float level = 0;
  float draw = 0;                      ///< scores that differ by less are a tie
  bool before = false, after = false;  ///< whether planes 0 and 3 exist
  PathBend path;
};

Moment momentAt(const ScoreStack& stack, double position);

/// Positions of a gap that are labelled together.
constexpr size_t kMoments = 8;

/// Up to kMoments positions in one gap, side by side.
struct Moments {
  Moment first;  ///< holds what they share
  size_t count = 0;
  float t[kMoments] = {}, limit[kMoments] = {}, cubic[4][kMoments] = {};
  PathBend path[kMoments];

  void add(const Moment& m) {
    if (!count) first = m;
    t[count] = m.t, limit[count] = m.limit;
    for (int k = 0; k < 4; ++k) cubic[k][count] = m.cubic[k];
    path[count] = m.path;
    ++count;
  }
};

/// Levels a score off at `level`: a contour far away has no influence within one gap.
inline float levelOff(float s, float level) {
  const float q = s / level;
  return s / std::sqrt(1 + q * q);
}

/// The cubic blend, limited to `limit` from the linear one.
inline float limited(float cubic, float linear, float limit) {
  return std::min(std::max(cubic, linear - limit), linear + limit);
}

}  // namespace slicemorph
