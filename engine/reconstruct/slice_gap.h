#pragma once

#include "engine/reconstruct/regions.h"
#include "engine/reconstruct/score_field.h"
#include "engine/reconstruct/slice_motion.h"

namespace slicemorph {

/// One label in one gap, with its fields on the four planes: two on either side of the gap.
struct GapLabel {
  int label = 0;
  ScoreField plane[4];
  float depth[2] = {0, 0};  ///< largest score on each of the gap's own two planes
  PixelBox box;             ///< contains the label throughout the gap
};

/// A region that moves to another position within a gap, although the smooth motion does not carry it there.
/// It takes precedence over everything that does not travel.
struct Traveller {
  size_t label = 0;  ///< index in the gap's list
  LabelScore a, b;
  float x = 0, y = 0;  ///< displacement from a to b, pixels
  /// Less than two pixels thick: moved by whole pixels, or it would vanish between them.
  bool thin = false;
  PixelBox box;
};

struct Gap {
  std::vector<GapLabel> labels;
  std::vector<Traveller> travellers;
  SliceMotion motion;
};

/// The gap's entry for one of its labels.
const GapLabel& labelIn(const Gap& gap, int label);

/// A stack of planes, and what was found about the gaps between them.
struct SlicePlan {
  ScoreStack stack;
  std::vector<std::vector<LabelRegions>> regions;  ///< per plane around the wanted gaps, and label
  std::vector<Gap> gaps;  ///< one less than planes; those that were not wanted have at most their motion
};

SlicePlan planSlices(ScoreStack stack, const GapRange& wanted);

}  // namespace slicemorph
