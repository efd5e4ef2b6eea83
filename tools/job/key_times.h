#pragma once

#include "slicemorph/conventions.h"

#include <string>
#include <vector>

/// The course of a sequence's weights over time: keys, what lies between them, an easing of the whole.
namespace slicemorph {

/// At this time, 0 to 1, the weights are these.
struct WeightKey {
  double at = 0;
  Weights weights;
};

/// Between keys. kSmoothstep stops at every key; kCatmullRom passes through the keys without a jump of speed,
/// and its weights go a little below 0 and above 1, no further than kLeastWeight. It stops where weights
/// stay: between two keys that are the same, before a first key that is not at 0, after a last one that is
/// not at 1.
enum class Timing { kLinear, kSmoothstep, kCatmullRom };

/// CSS's cubic-bezier(x1, y1, x2, y2), from (0, 0) to (1, 1): time along x, from 0 to 1, eased time along y.
/// [CSS Easing Functions Level 1, W3C]
struct Easing {
  double x1 = 0, y1 = 0, x2 = 1, y2 = 1;  ///< these: linear
};

/// Before the first key and after the last one weights stay.
struct WeightCourse {
  std::vector<WeightKey> keys;  ///< times rise
  Timing timing = Timing::kLinear;
  Easing easing;
  std::vector<Weights> tangents;  ///< per key: change of the weights per unit of eased time
};

/// Input after input, evenly spaced from 0 to 1; two or more.
std::vector<WeightKey> evenKeys(size_t inputs);

/// With the tangents that its timing asks for.
WeightCourse courseOf(std::vector<WeightKey> keys, Timing timing, const Easing& easing);

/// Weights at a time, 0 to 1; within 1e-9 of a key the key's own.
Weights weightsAt(const WeightCourse& course, double t);

/// Their change per unit of time: where it jumps that of the stretch that follows, at 1 that of the last one.
Weights slopeAt(const WeightCourse& course, double t);

double easedTime(const Easing& easing, double t);
/// Where the curve stands upright for a moment, the mean of 1/1000 of the time around.
double easedSpeed(const Easing& easing, double t);

/// `linear`, `in`, `out`, `in-out` as CSS has them, or X1,Y1,X2,Y2. Throws InputError.
Easing parseEasing(const std::string& option, const std::string& text);

/// Weights of sum 1, and what was done to get there; empty: nothing.
struct CheckedWeights {
  Weights weights;
  std::string note;
};
/// `said`: what the messages begin with. Throws InputError for another number than that of the inputs, for
/// negative numbers and ones that are not finite, for a sum of 0.
CheckedWeights checkWeights(const std::string& said, const Weights& weights, size_t inputs);

/// What is wrong with a key's time, after the one before it; empty: nothing. `before`: null for the first.
std::string faultOfTime(double at, const WeightKey* before);

/// `INPUT@TIME INPUT@TIME ...`, parted by spaces or commas; inputs as inputNamed() knows them. Throws
/// InputError.
std::vector<WeightKey> parseKeys(const std::string& option, const std::string& text,
                                 const std::vector<std::string>& inputs);

/// A note on the inputs that no key shows; empty: each is shown.
std::string noteOfUnused(const std::vector<WeightKey>& keys, const std::vector<std::string>& inputs);

}  // namespace slicemorph
