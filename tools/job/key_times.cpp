#include "tools/job/key_times.h"

#include "slicemorph/errors.h"
#include "slicemorph/slicemorph.h"
#include "tools/job/input_names.h"
#include "tools/job/option_values.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <sstream>

namespace slicemorph {
namespace {

/// Times that differ by less are equal: far above the rounding of times computed as i / (n - 1).
constexpr double kSameTime = 1e-9;
/// Tangents that lead too far are multiplied by this until they do not: they end at most 5 %
/// shorter than needed.
constexpr double kShorter = 0.95;

/// Weight 1 for one input, 0 for the others.
Weights only(size_t input, size_t inputs) {
  Weights weights(inputs, 0.0);
  weights[input] = 1;
  return weights;
}

double length(const WeightCourse& course, size_t stretch) {
  return course.keys[stretch + 1].at - course.keys[stretch].at;
}

/// Mean rate of change of one weight between a key and the next, per unit of eased time.
double secant(const WeightCourse& course, size_t stretch, size_t input) {
  const double change = course.keys[stretch + 1].weights[input] - course.keys[stretch].weights[input];
  return change / length(course, stretch);
}

/// Whether weights are constant from a key to the next; `stretch` -1: before the first key.
bool stays(const WeightCourse& course, size_t stretch) {
  if (stretch == size_t(-1)) return course.keys.front().at > 0;
  if (stretch + 1 == course.keys.size()) return course.keys.back().at < 1;
  return course.keys[stretch].weights == course.keys[stretch + 1].weights;
}

/// The derivative of the parabola through three keys, at the middle one.
double tangentBetween(const WeightCourse& course, size_t key, size_t input) {
  const double before = length(course, key - 1), after = length(course, key);
  return (after * secant(course, key - 1, input) + before * secant(course, key, input)) / (before + after);
}

/// Catmull-Rom tangents [CR74] for uneven keys; at the ends the second derivative is 0.
void setTangents(WeightCourse& course) {
  const size_t last = course.keys.size() - 1;
  const auto set = [&](size_t key, const auto& tangentOf) {
    if (stays(course, key - 1) || stays(course, key)) return;
    for (size_t k = 0; k < course.tangents[key].size(); ++k) course.tangents[key][k] = tangentOf(k);
  };
  for (size_t key = 1; key < last; ++key) set(key, [&](size_t k) { return tangentBetween(course, key, k); });
  if (last == 1 && !stays(course, 0) && !stays(course, size_t(-1)) && !stays(course, 1)) {
    for (const size_t key : {0, 1}) set(key, [&](size_t k) { return secant(course, 0, k); });
    return;
  }
  set(0, [&](size_t k) { return 1.5 * secant(course, 0, k) - 0.5 * course.tangents[1][k]; });
  set(last, [&](size_t k) { return 1.5 * secant(course, last - 1, k) - 0.5 * course.tangents[last - 1][k]; });
}

/// The minimum of a weight between a key and the next: of the cubic at its ends and where its
/// derivative is 0.
double leastBetween(const WeightCourse& course, size_t stretch, size_t input) {
  const double from = course.keys[stretch].weights[input], to = course.keys[stretch + 1].weights[input];
  const double first = course.tangents[stretch][input] * length(course, stretch),
               last = course.tangents[stretch + 1][input] * length(course, stretch);
  const double cubed = first + last - 2 * (to - from), squared = 3 * (to - from) - 2 * first - last;
  const double root = squared * squared - 3 * cubed * first;
  double least = std::min(from, to);
  if (root < 0) return least;
  // The two roots by the stable form of the quadratic formula. For straight and parabolic courses `cubed` or
  // `sum` is 0; the quotient is then infinite or NaN and is ignored below.
  const double sum = -squared - std::copysign(std::sqrt(root), squared);
  for (const double s : {sum / (3 * cubed), first / sum})
    if (s > 0 && s < 1) least = std::min(least, from + s * (first + s * (squared + s * cubed)));
  return least;
}

bool leadsTooFar(const WeightCourse& course, size_t stretch) {
  for (size_t k = 0; k < course.tangents[stretch].size(); ++k)
    if (leastBetween(course, stretch, k) < kLeastWeight) return true;
  return false;
}

/// Shortens tangents that lead a weight below kLeastWeight. All components of a key's tangent are shortened
/// alike, so that their sum stays 0 and the speed is the same on both sides of the key. This ends, since
/// without tangents weights stay between those of the keys.
void limitTangents(WeightCourse& course) {
  for (bool changed = true; changed;) {
    changed = false;
    std::vector<bool> tooLong(course.keys.size(), false);
    for (size_t i = 0; i + 1 < course.keys.size(); ++i)
      if (leadsTooFar(course, i)) tooLong[i] = tooLong[i + 1] = changed = true;
    for (size_t key = 0; key < course.keys.size(); ++key)
      if (tooLong[key])
        for (double& tangent : course.tangents[key]) tangent *= kShorter;
  }
}

/// A cubic Bezier curve in one dimension with the control values 0, `first`, `second`, 1.
double bezier(double first, double second, double s) {
  const double rest = 1 - s;
  return s * (3 * rest * (rest * first + s * second) + s * s);
}

double bezierSlope(double first, double second, double s) {
  const double rest = 1 - s;
  return 3 * (rest * rest * first + 2 * rest * s * (second - first) + s * s * (1 - second));
}

/// The curve's parameter at time t. Times rise along the curve, so bisection finds it; 60 steps reach the
/// precision of doubles.
double parameterAt(const Easing& e, double t) {
  double low = 0, high = 1;
  for (int i = 0; i < 60; ++i) {
    const double middle = 0.5 * (low + high);
    (bezier(e.x1, e.x2, middle) < t ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

bool isLinear(const Easing& e) { return e.x1 == e.y1 && e.x2 == e.y2; }

/// Eased time, or that of a key within kSameTime of it.
double keyTimeAt(const WeightCourse& course, double t) {
  const double eased = easedTime(course.easing, t);
  for (const WeightKey& key : course.keys)
    if (std::abs(key.at - eased) <= kSameTime) return key.at;
  return eased;
}

std::vector<std::string> wordsOf(std::string text) {
  std::replace(text.begin(), text.end(), ',', ' ');
  std::istringstream stream(text);
  std::vector<std::string> words;
  for (std::string word; stream >> word;) words.push_back(word);
  return words;
}

}  // namespace

Timing timingNamed(const std::string& name) {
  return name == "smoothstep"    ? Timing::kSmoothstep
         : name == "catmull-rom" ? Timing::kCatmullRom
                                 : Timing::kLinear;
}

std::vector<WeightKey> evenKeys(size_t inputs) {
  std::vector<WeightKey> keys;
  for (size_t k = 0; k < inputs; ++k) keys.push_back({double(k) / double(inputs - 1), only(k, inputs)});
  return keys;
}

WeightCourse courseOf(std::vector<WeightKey> keys, Timing timing, const Easing& easing) {
  WeightCourse course{std::move(keys), timing, easing, {}};
  course.tangents.assign(course.keys.size(), Weights(course.keys[0].weights.size(), 0.0));
  if (timing == Timing::kCatmullRom && course.keys.size() > 1) {
    setTangents(course);
    limitTangents(course);
  }
  return course;
}

Weights weightsAt(const WeightCourse& course, double t) {
  const std::vector<WeightKey>& keys = course.keys;
  const double time = keyTimeAt(course, t);
  const auto next = std::lower_bound(keys.begin(), keys.end(), time,
                                     [](const WeightKey& key, double at) { return key.at < at; });
  if (next == keys.end()) return keys.back().weights;
  if (next == keys.begin() || next->at == time) return next->weights;
  const size_t i = size_t(next - keys.begin()) - 1;
  const double span = length(course, i), s = (time - keys[i].at) / span;
  Weights weights = keys[i].weights;
  for (size_t k = 0; k < weights.size(); ++k) {
    const double change = next->weights[k] - weights[k];
    weights[k] += change * (course.timing == Timing::kLinear ? s : s * s * (3 - 2 * s));
    weights[k] += span * s * (1 - s) * (course.tangents[i][k] * (1 - s) - course.tangents[i + 1][k] * s);
  }
  return weights;
}

Weights slopeAt(const WeightCourse& course, double t) {
  const std::vector<WeightKey>& keys = course.keys;
  Weights slope(keys[0].weights.size(), 0.0);
  const double speed = easedSpeed(course.easing, t), time = keyTimeAt(course, t);
  // Eased time can also run backwards: an easing may overshoot its ends. At a key the stretch that follows
  // counts, at t = 1 the one before.
  const bool upwards = (speed >= 0) == (t < 1);
  const size_t before = size_t(std::count_if(keys.begin(), keys.end(), [&](const WeightKey& key) {
    return upwards ? key.at <= time : key.at < time;
  }));
  if (before == 0 || before == keys.size()) return slope;
  const size_t i = before - 1;
  const double s = (time - keys[i].at) / length(course, i);
  for (size_t k = 0; k < slope.size(); ++k) {
    const double first = course.tangents[i][k], last = course.tangents[i + 1][k];
    slope[k] = secant(course, i, k) * (course.timing == Timing::kLinear ? 1 : 6 * s * (1 - s));
    slope[k] += first * (1 - s) * (1 - 3 * s) - last * s * (2 - 3 * s);
    slope[k] *= speed;
  }
  return slope;
}

double easedTime(const Easing& e, double t) {
  if (isLinear(e) || t <= 0 || t >= 1) return t;
  return bezier(e.y1, e.y2, parameterAt(e, t));
}

double easedSpeed(const Easing& e, double t) {
  if (isLinear(e)) return 1;
  // At an end the tangent points to the nearest control point that differs from the end.
  if (t <= 0 && e.x1 > 0) return e.y1 / e.x1;
  if (t <= 0 && e.y1 == 0 && e.x2 > 0) return e.y2 / e.x2;
  if (t >= 1 && e.x2 < 1) return (1 - e.y2) / (1 - e.x2);
  if (t >= 1 && e.y2 == 1 && e.x1 < 1) return (1 - e.y1) / (1 - e.x1);
  const double s = parameterAt(e, std::clamp(t, 0.0, 1.0)), dx = bezierSlope(e.x1, e.x2, s);
  if (t > 0 && t < 1 && dx > 1e-3) return bezierSlope(e.y1, e.y2, s) / dx;
  const double from = std::max(t - 5e-4, 0.0), to = std::min(t + 5e-4, 1.0);
  return (easedTime(e, to) - easedTime(e, from)) / (to - from);
}

Easing parseEasing(const std::string& option, const std::string& text) {
  // The keywords' curves are those of CSS Easing Functions Level 1.
  if (text == "linear") return {};
  if (text == "in") return {0.42, 0, 1, 1};
  if (text == "out") return {0, 0, 0.58, 1};
  if (text == "in-out") return {0.42, 0, 0.58, 1};
  const std::string expected = "; expected linear, in, out, in-out or X1,Y1,X2,Y2, for example 0.3,0,0.2,1";
  std::vector<double> n;
  try {
    n = parseNumbers(option, text);
  } catch (const InputError&) {
    throw InputError(option + " " + text + " is no easing" + expected);
  }
  if (n.size() != 4) throw InputError(option + " " + text + " has not four numbers" + expected);
  for (const double x : {n[0], n[2]})
    if (x < 0 || x > 1)
      throw InputError(option + " " + text + ": " + formatNumber(x) + " is no time; X1 and X2 are 0 to 1");
  return {n[0], n[1], n[2], n[3]};
}

CheckedWeights checkWeights(const std::string& said, const Weights& weights, size_t inputs) {
  if (weights.size() != inputs)
    throw InputError(said + " has " + std::to_string(weights.size()) + " numbers for " +
                     std::to_string(inputs) + " inputs; give one weight per input");
  for (const double w : weights) {
    if (!std::isfinite(w)) throw InputError(said + ": a weight is not finite; weights are 0 or more");
    if (w < 0) throw InputError(said + ": " + formatNumber(w) + " is negative; weights are 0 or more");
  }
  const double sum = std::accumulate(weights.begin(), weights.end(), 0.0);
  if (sum == 0) throw InputError(said + " are all 0; at least one input must have a weight above 0");
  if (!std::isfinite(sum)) throw InputError(said + " are too large to be added; give numbers of sum 1");
  if (std::abs(sum - 1) <= 1e-6) return {weights, ""};
  CheckedWeights checked{weights, said + " sum to " + formatNumber(sum, 9) + ": taken as "};
  for (size_t k = 0; k < inputs; ++k) {
    checked.weights[k] /= sum;
    checked.note += (k ? "," : "") + formatNumber(checked.weights[k], 9);
  }
  return checked;
}

std::string faultOfTime(double at, const WeightKey* before) {
  if (!(at >= 0 && at <= 1)) return "the time " + formatNumber(at) + " is out of range; times are 0 to 1";
  if (before && at <= before->at)
    return "the time " + formatNumber(at) + " is not after " + formatNumber(before->at) + "; times must rise";
  return "";
}

std::vector<WeightKey> parseKeys(const std::string& option, const std::string& text,
                                 const std::vector<std::string>& inputs) {
  const std::string said = option + " " + text + ": ";
  std::vector<WeightKey> keys;
  for (const std::string& word : wordsOf(text)) {
    const size_t mark = word.rfind('@');
    const std::string time = mark == std::string::npos ? "" : word.substr(mark + 1);
    char* end = nullptr;
    const double at = std::strtod(time.c_str(), &end);
    if (mark == 0 || time.empty() || *end != 0)
      throw InputError(said + "'" + word + "' is no key; expected INPUT@TIME, for example a@0 b@0.5 c@1");
    const std::string fault = faultOfTime(at, keys.empty() ? nullptr : &keys.back());
    if (!fault.empty()) throw InputError(said + "'" + word + "': " + fault);
    try {
      keys.push_back({at, only(inputNamed(word.substr(0, mark), inputs), inputs.size())});
    } catch (const InputError& error) {
      throw InputError(said + error.what());
    }
  }
  if (keys.empty())
    throw InputError(option + " holds no key; expected INPUT@TIME, for example a@0 b@0.5 c@1");
  return keys;
}

std::string noteOfUnused(const std::vector<WeightKey>& keys, const std::vector<std::string>& inputs) {
  std::string names;
  for (size_t k = 0; k < inputs.size(); ++k)
    if (std::none_of(keys.begin(), keys.end(), [&](const WeightKey& key) { return key.weights[k] > 0; }))
      names += (names.empty() ? "" : ", ") + inputs[k];
  return names.empty() ? "" : "no key shows " + names;
}

}  // namespace slicemorph
