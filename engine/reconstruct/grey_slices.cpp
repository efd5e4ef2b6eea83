#include "engine/reconstruct/grey_slices.h"

#include "engine/numerics/parallel_each.h"
#include "engine/reconstruct/grey_motion.h"
#include "slicemorph/errors.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <string>
#include <type_traits>

namespace slicemorph {

namespace {

GreySlice sliceOf(const Image& grey, const SliceLayout& layout, int at) {
  GreySlice slice{layout.width, layout.height, {}};
  slice.values.resize(size_t(layout.width) * size_t(layout.height));
  std::visit(
      [&](const auto& values) {
        for (int y = 0; y < layout.height; ++y)
          for (int x = 0; x < layout.width; ++x)
            slice.values[size_t(y) * size_t(layout.width) + size_t(x)] =
                float(values[size_t(at) * layout.slice + size_t(y) * layout.y + size_t(x) * layout.x]);
      },
      grey.values);
  return slice;
}

/// The value at (x, y) at fraction t of the way from a to b.
float between(const GreySlice& a, const GreySlice& b, const SliceMotion& motion, float t, float x, float y) {
  // The motion is a function of the place half way.
  SliceMotion::Vector v = motion.at(x, y);
  v = motion.at(x - (t - .5f) * v.x, y - (t - .5f) * v.y);
  return (1 - t) * a.at(x - t * v.x, y - t * v.y) + t * b.at(x + (1 - t) * v.x, y + (1 - t) * v.y);
}

SliceMotion scaled(SliceMotion motion, float share) {
  for (float& x : motion.x) x *= share;
  for (float& y : motion.y) y *= share;
  return motion;
}

/// How much of the motion tells of what is between: the share of it by which given slices are best made of the ones before
/// and after them. All of it where there are no three.
float trustedShare(const Image& grey, const SliceLayout& layout, const std::vector<int>& at) {
  constexpr std::array<float, 4> kShares = {1, 0.5f, 0.25f, 0};
  constexpr size_t kTried = 12;  // slices
  if (at.size() < 3) return 1;
  const size_t stride = std::max<size_t>(1, (at.size() - 2) / kTried), count = (at.size() - 3) / stride + 1;
  std::vector<std::array<double, kShares.size()>> errors(count);
  parallelEach(count, [&](size_t n) {
    const size_t g = 1 + n * stride;
    const GreySlice a = sliceOf(grey, layout, at[g - 1]), b = sliceOf(grey, layout, at[g + 1]),
                    truth = sliceOf(grey, layout, at[g]);
    const float t = float(at[g] - at[g - 1]) / float(at[g + 1] - at[g - 1]);
    const SliceMotion motion = greyMotion(a, b);
    for (size_t s = 0; s < kShares.size(); ++s) {
      const SliceMotion part = scaled(motion, kShares[s]);
      double sum = 0;
      for (int y = 0; y < truth.height; ++y)
        for (int x = 0; x < truth.width; ++x) {
          const double off = double(between(a, b, part, t, float(x), float(y))) -
                             double(truth.values[size_t(y) * size_t(truth.width) + size_t(x)]);
          if (std::isfinite(off)) sum += off * off;
        }
      errors[n][s] = sum;
    }
  });
  std::array<double, kShares.size()> total{};
  for (const auto& error : errors)
    for (size_t s = 0; s < kShares.size(); ++s) total[s] += error[s];
  return kShares[size_t(std::min_element(total.begin(), total.end()) - total.begin())];
}

template <typename T>
T rounded(float value) {
  if constexpr (std::is_integral_v<T>)
    return T(std::lround(value));
  else
    return T(value);
}

}  // namespace

void ValuesSeen::add(const ImageValues& slab, const openvdb::Coord& size) {
  const size_t step[3] = {1, size_t(size[0]), size_t(size[0]) * size_t(size[1])};
  std::visit(
      [&](const auto& values) {
        using T = typename std::decay_t<decltype(values)>::value_type;
        const T least = *std::min_element(values.begin(), values.end());
        for (size_t n = 0; n < values.size(); ++n) {
          const T v = values[n];
          if (v == T(0) || v == least) continue;  // between slices, and around what is on them
          if constexpr (std::is_floating_point_v<T>)
            if (!(v == std::rint(v))) fractions_ = true;
          if (first_ == 0) first_ = double(v);
          others_ |= double(v) != first_;
          const openvdb::Coord at(int(n % step[1]), int(n / step[1] % size_t(size[1])), int(n / step[2]));
          for (int a = 0; a < 3; ++a)
            if (at[a] + 1 < size[a]) ++pairs_[a], same_[a] += values[n + step[a]] == v;
        }
      },
      slab);
}

bool ValuesSeen::looksDrawn() const {
  constexpr double kSame = 0.4;  // share of equal neighbours, as in looksLikeLabels()
  if (fractions_) return false;
  bool alike = !others_;
  for (int a = 0; a < 3; ++a) alike = alike || (pairs_[a] > 0 && same_[a] >= kSame * pairs_[a]);
  return alike;
}

std::vector<char> slicesWithValues(const Image& grey, int axis) {
  const SliceLayout layout = layoutOf(grey.lattice, axis);
  std::vector<char> found(size_t(grey.lattice.size[axis]), 0);
  parallelEach(found.size(), [&](size_t k) {
    std::visit(
        [&](const auto& values) {
          const auto first = values[k * layout.slice];
          for (int y = 0; y < layout.height && !found[k]; ++y)
            for (int x = 0; x < layout.width && !found[k]; ++x) {
              const auto value = values[k * layout.slice + size_t(y) * layout.y + size_t(x) * layout.x];
              found[k] = value != first && (value == value || first == first);  // NaN is as NaN
            }
        },
        grey.values);
  });
  return found;
}

Image interpolateGrey(Image grey, const GivenSlices& given) {
  checkGivenSlices(grey.lattice, given);
  const SliceLayout layout = layoutOf(grey.lattice, given.axis);
  const float share = trustedShare(grey, layout, given.at);
  parallelEach(given.at.size() - 1, [&](size_t g) {
    const int first = given.at[g], gap = given.at[g + 1] - first;
    if (gap < 2) return;
    const GreySlice a = sliceOf(grey, layout, first), b = sliceOf(grey, layout, first + gap);
    const SliceMotion motion = scaled(greyMotion(a, b), share);
    std::visit(
        [&](auto& values) {
          using T = typename std::decay_t<decltype(values)>::value_type;
          for (int k = 1; k < gap; ++k)
            for (int y = 0; y < layout.height; ++y)
              for (int x = 0; x < layout.width; ++x)
                values[size_t(first + k) * layout.slice + size_t(y) * layout.y + size_t(x) * layout.x] =
                    rounded<T>(between(a, b, motion, float(k) / float(gap), float(x), float(y)));
        },
        grey.values);
  });
  return grey;
}

}  // namespace slicemorph
