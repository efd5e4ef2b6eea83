#pragma once

#include "slicemorph/conventions.h"

#include <string>
#include <vector>

/// The weights of a sequence over time: keys, interpolation between them, an easing of the whole.
namespace slicemorph {

/// The weights at a time, 0 to 1.
struct WeightKey {
  double at = 0;
  Weights weights;
};

/// Interpolation between keys. kSmoothstep stops at every key; kCatmullRom passes through the keys without a
/// jump of speed, and its weights may be a little below 0, but not below kLeastWeight, and above 1. It stops
/// where weights are constant: between two equal keys, before a first key that is not at 0, after a last one
/// that is not at 1.
enum class Timing { kLinear, kSmoothstep, kCatmullRom };

/// cubic-bezier(x1, y1, x2, y2) of CSS Easing Functions Level 1 (W3C), from (0, 0) to (1, 1): time along x,
/// eased time along y.
struct Easing {
  double x1 = 0, y1 = 0, x2 = 1, y2 = 1;  ///< the defaults are linear
};

/// Before the first key and after the last one weights are constant.
struct WeightCourse {
  std::vector<WeightKey> keys;  ///< times rise
  Timing timing = Timing::kLinear;
  Easing easing;
  std::vector<Weights> tangents;  ///< per key: change of the weights per unit of eased time
};

/// By its name: linear, smoothstep, catmull-rom.
Timing timingNamed(const std::string& name);

/// One key per input, evenly spaced from 0 to 1; two inputs or more.
std::vector<WeightKey> evenKeys(size_t inputs);

/// A course with the tangents that its timing needs.
WeightCourse courseOf(std::vector<WeightKey> keys, Timing timing, const Easing& easing);

/// Weights at a time, 0 to 1; within 1e-9 of a key those of the key.
Weights weightsAt(const WeightCourse& course, double t);

/// Derivative of weightsAt; where it jumps, that of the stretch that follows, and at 1 that of the last one.
Weights slopeAt(const WeightCourse& course, double t);

double easedTime(const Easing& easing, double t);
/// Derivative of easedTime; where the curve is vertical, the mean over 1/1000 of the time around t.
double easedSpeed(const Easing& easing, double t);

/// Parses `linear`, `in`, `out`, `in-out` (CSS's `ease-in` and so on), or X1,Y1,X2,Y2. Throws InputError.
Easing parseEasing(const std::string& option, const std::string& text);

/// Weights of sum 1, and a note if they were normalised to that.
struct CheckedWeights {
  Weights weights;
  std::string note;
};
/// `said`: the beginning of messages. Throws InputError unless there is one weight per input, all are finite
/// and not negative, and their sum is above 0.
CheckedWeights checkWeights(const std::string& said, const Weights& weights, size_t inputs);

/// What is wrong with a key's time; empty: nothing. `before`: the key before it, null for the first.
std::string faultOfTime(double at, const WeightKey* before);

/// Parses `INPUT@TIME INPUT@TIME ...`, separated by spaces or commas; inputs as inputNamed() knows
/// them. Throws InputError.
std::vector<WeightKey> parseKeys(const std::string& option, const std::string& text,
                                 const std::vector<std::string>& inputs);

/// A note on the inputs that have no weight in any key; empty: all have some.
std::string noteOfUnused(const std::vector<WeightKey>& keys, const std::vector<std::string>& inputs);

}  // namespace slicemorph
