#pragma once

#include "engine/reconstruct/score_field.h"
#include "engine/reconstruct/slice_motion.h"

namespace slicemorph {

/// One label in one gap: its fields on the planes before, at, at and after it.
struct GapLabel {
  int label = 0;
  ScoreField plane[4];
  float depth[2] = {0, 0};  ///< greatest score on either plane
  PixelBox box;             ///< holds it throughout
};

/// A region that goes to another place within a gap, where the smooth motion does not take it: it has the way
/// before all that stays.
struct Traveller {
  size_t label = 0;  ///< place in the gap's list
  LabelScore a, b;
  float x = 0, y = 0;  ///< from a to b, pixels
  bool thin = false;   ///< less than two pixels thick: carried by whole pixels, or it would fall between them
  PixelBox box;
};

struct Gap {
  std::vector<GapLabel> labels;
  std::vector<Traveller> travellers;
  SliceMotion motion;
};

/// A stack of planes, and what is known of the gaps between them.
struct SlicePlan {
  ScoreStack stack;
  std::vector<Gap> gaps;
};

SlicePlan planSlices(ScoreStack stack);

}  // namespace slicemorph
