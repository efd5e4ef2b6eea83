#pragma once

#include "engine/peers/scheduled_dissolve.h"

namespace slicemorph {

/// Schedule of the Fourier dissolve; its numbers are ours.
struct FourierOptions {
  /// How far the way has gone when the finest parts of the first object are gone; those of the second come as late.
  double fade = 0.5;
  /// From so many half waves along the box's longest side on, parts are the finest.
  double cutoff = 16;
};

/// The transform for ScheduledDissolve [Hug92]. Values are continued by mirrors at the box's sides, so that they go on
/// without a jump: of their Fourier series only cosines are left, as many as there are nodes.
std::unique_ptr<LatticeTransform> cosineTransform(double cutoff);

}  // namespace slicemorph
