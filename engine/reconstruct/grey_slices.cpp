#include "engine/reconstruct/grey_slices.h"

#include "engine/numerics/parallel_each.h"
#include "engine/reconstruct/grey_motion.h"
#include "slicemorph/errors.h"

#include <algorithm>
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
            for (int x = 0; x < layout.width; ++x)
              if (values[k * layout.slice + size_t(y) * layout.y + size_t(x) * layout.x] != first) {
                found[k] = 1;
                break;
              }
        },
        grey.values);
  });
  return found;
}

Image interpolateGrey(Image grey, const GivenSlices& given) {
  checkGivenSlices(grey.lattice, given);
  const SliceLayout layout = layoutOf(grey.lattice, given.axis);
  parallelEach(given.at.size() - 1, [&](size_t g) {
    const int first = given.at[g], gap = given.at[g + 1] - first;
    if (gap < 2) return;
    const GreySlice a = sliceOf(grey, layout, first), b = sliceOf(grey, layout, first + gap);
    const SliceMotion motion = greyMotion(a, b);
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
