#pragma once

#include "engine/peers/scheduled_dissolve.h"

namespace slicemorph {

/// Schedule of the wavelet dissolve.
struct WaveletOptions {
  /// As of FourierOptions.
  double fade = 0.5;
  /// Levels of the wavelet; at the last one a block of 2^levels voxels is one value.
  int levels = 4;
};

/// The transform for ScheduledDissolve by levels of a wavelet [HWK94], here Haar's in three dimensions: of two neighbours
/// the mean and half the difference, and of the means again. Details of each level are a part of their own fineness.
std::unique_ptr<LatticeTransform> haarTransform(int levels);

}  // namespace slicemorph
