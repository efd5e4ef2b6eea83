#pragma once

#include "slicemorph/image.h"

#include <tbb/blocked_range.h>
#include <tbb/parallel_reduce.h>

#include <algorithm>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <type_traits>

namespace slicemorph {

/// Converts a value to an image's number type; for integers it is clamped and rounded to the nearest.
template <typename T>
T storedValue(double value) {
  if constexpr (!std::is_integral_v<T>) return T(value);
  const double low = double(std::numeric_limits<T>::min()), high = double(std::numeric_limits<T>::max());
  // Offset to the lowest value, so that truncation rounds down.
  const double steps = std::min(std::max(value, low), high) - low + 0.5;
  return T(std::int64_t(steps) + std::int64_t(low));
}

/// The lowest value of an image, used outside of it. 0 for an empty image.
template <typename T>
T lowestValue(const std::vector<T>& values) {
  if (values.empty()) return T(0);
  return tbb::parallel_reduce(
      tbb::blocked_range<size_t>(0, values.size(), 1 << 16), values[0],
      [&](const tbb::blocked_range<size_t>& range, T low) {
        for (size_t i = range.begin(); i < range.end(); ++i) low = values[i] < low ? values[i] : low;
        return low;
      },
      [](T a, T b) { return std::min(a, b); });
}

/// Trilinear values of an image. Up to half a voxel beyond the outermost voxel centres the nearest voxels'
/// values are used, further out the image's lowest value.
template <typename T>
class ImageSampler {
 public:
  /// Numbers of up to 16 bits and floats are exact in single precision.
  using Real = std::conditional_t<(sizeof(T) <= 2) || std::is_same_v<T, float>, float, double>;

  ImageSampler(const ImageLattice& lattice, const std::vector<T>& values)
      : values_(values.data()),
        n_(lattice.size),
        y_(size_t(n_[0])),
        z_(size_t(n_[0]) * n_[1]),
        outside_(Real(lowestValue(values))) {}

  /// `p`: voxel coordinates.
  Real operator()(const openvdb::Vec3s& p) const { return within(p) ? inside(p[0], p[1], p[2]) : atFace(p); }

  /// Adds `weight` times the values at `count` positions that are `step` apart to `sum`.
  void addLine(const openvdb::Vec3s& first, const openvdb::Vec3s& step, int count, double weight,
               double* sum) const {
    if (within(first) && within(first + step * float(count - 1))) {
      for (int n = 0; n < count; ++n)
        sum[n] += weight * double(inside(first[0] + step[0] * float(n), first[1] + step[1] * float(n),
                                         first[2] + step[2] * float(n)));
    } else {
      for (int n = 0; n < count; ++n) sum[n] += weight * double((*this)(first + step * float(n)));
    }
  }

 private:
  bool within(const openvdb::Vec3s& p) const {
    return p[0] >= 0 && p[1] >= 0 && p[2] >= 0 && p[0] < float(n_[0] - 1) && p[1] < float(n_[1] - 1) &&
           p[2] < float(n_[2] - 1);
  }

  Real inside(float px, float py, float pz) const {
    const int i = int(px), j = int(py), k = int(pz);
    const T *v = values_ + size_t(k) * z_ + size_t(j) * y_ + size_t(i), *w = v + z_;
    const Real x = px - float(i), y = py - float(j), z = pz - float(k);
    if constexpr (sizeof(T) == 2 && __BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__) {
      // Interpolates the four pairs along i at once; most of the time of a frame is spent here.
      using Four = float __attribute__((vector_size(16)));
      using Whole = std::int32_t __attribute__((vector_size(16)));
      const Whole pairs = {pairAt(v), pairAt(v + y_), pairAt(w), pairAt(w + y_)};
      const Whole low = std::is_signed_v<T> ? (pairs << 16) >> 16 : pairs & 0xffff;
      const Whole high = std::is_signed_v<T> ? pairs >> 16 : (pairs >> 16) & 0xffff;
      const Four first = __builtin_convertvector(low, Four);
      const Four along = first + x * (__builtin_convertvector(high, Four) - first);
      const float front = along[0] + y * (along[1] - along[0]), back = along[2] + y * (along[3] - along[2]);
      return front + z * (back - front);
    }
    const Real a = v[0] + x * (Real(v[1]) - v[0]), b = v[y_] + x * (Real(v[y_ + 1]) - v[y_]);
    const Real c = w[0] + x * (Real(w[1]) - w[0]), d = w[y_] + x * (Real(w[y_ + 1]) - w[y_]);
    const Real front = a + y * (b - a), back = c + y * (d - c);
    return front + z * (back - front);
  }

  /// Two consecutive values, the first in the lower half.
  static std::int32_t pairAt(const T* v) {
    std::int32_t pair;
    std::memcpy(&pair, v, sizeof pair);
    return pair;
  }

  Real atFace(const openvdb::Vec3s& p) const {
    int at[3];
    Real f[3];
    for (int d = 0; d < 3; ++d) {
      if (!(p[d] >= -0.5f && p[d] <= float(n_[d]) - 0.5f)) return outside_;
      const float q = std::min(std::max(p[d], 0.f), float(n_[d] - 1));
      at[d] = std::max(0, std::min(int(q), n_[d] - 2));
      f[d] = q - float(at[d]);
    }
    Real sum = 0;
    for (int c = 0; c < 8; ++c) {
      const Real w = (c & 1 ? f[0] : 1 - f[0]) * (c & 2 ? f[1] : 1 - f[1]) * (c & 4 ? f[2] : 1 - f[2]);
      if (w > 0)
        sum += w * Real(values_[size_t(at[2] + (c >> 2)) * z_ + size_t(at[1] + (c >> 1 & 1)) * y_ +
                                size_t(at[0] + (c & 1))]);
    }
    return sum;
  }

  const T* values_;
  openvdb::Coord n_;
  size_t y_, z_;
  Real outside_;
};

}  // namespace slicemorph
