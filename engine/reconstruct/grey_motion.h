#pragma once

#include "engine/reconstruct/slice_motion.h"

namespace slicemorph {

/// Values of a slice, row by row.
struct GreySlice {
  int width = 0, height = 0;
  std::vector<float> values;

  /// Bilinear; outside the values of the border.
  float at(float x, float y) const;
};

/// The motion that carries the values of one slice onto those of another, as a function of position half way between
/// them: least squares on the differences of values over windows, from coarse to fine ([LK81], on half-size images).
/// Symmetric: the other way round it is the negative. Zero where nothing is gained by moving.
SliceMotion greyMotion(const GreySlice& a, const GreySlice& b);

}  // namespace slicemorph
