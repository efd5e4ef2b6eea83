#include "engine/numerics/distance_transform.h"

#include "engine/numerics/lower_envelope.h"

#include <tbb/parallel_for.h>

#include <cmath>

namespace slicemorph {
namespace {

/// larger than any squared distance: no voxel of the other kind is known yet
constexpr float kFarSquared = 1e20f;

/// Transforms lines of squared distances.
class DistanceLine {
 public:
  DistanceLine(int longest, double spacing)
      : unit_(float(spacing) * float(spacing)), value_(size_t(longest)), envelope_(longest, double(unit_)) {}

  /// Transforms `n` values in place, `stride` apart.
  void transform(float* values, size_t stride, int n) {
    envelope_.clear();
    for (int q = 0; q < n; ++q) {
      value_[size_t(q)] = values[size_t(q) * stride];
      if (value_[size_t(q)] < kFarSquared) envelope_.add(q, double(value_[size_t(q)]));
    }
    if (envelope_.empty()) return;
    for (int q = 0; q < n; ++q) {
      const int apex = envelope_.nearest(q);
      const float d = float(q - apex);
      values[size_t(q) * stride] = unit_ * d * d + value_[size_t(apex)];
    }
  }

 private:
  float unit_;
  std::vector<float> value_;
  LowerEnvelope<double> envelope_;
};

/// Squared distances to the voxels whose value is 0. The others must be kFarSquared.
void squaredDistances(std::vector<float>& d, const openvdb::Coord& n, const Vec3d& spacing) {
  const size_t row = size_t(n[0]), plane = row * size_t(n[1]);
  tbb::parallel_for(0, n[2], [&](int k) {
    DistanceLine x(n[0], spacing[0]), y(n[1], spacing[1]);
    float* slice = &d[size_t(k) * plane];
    for (int j = 0; j < n[1]; ++j) x.transform(slice + size_t(j) * row, 1, n[0]);
    for (int i = 0; i < n[0]; ++i) y.transform(slice + i, row, n[1]);
  });
  tbb::parallel_for(0, n[1], [&](int j) {
    DistanceLine z(n[2], spacing[2]);
    for (int i = 0; i < n[0]; ++i) z.transform(&d[size_t(j) * row + size_t(i)], plane, n[2]);
  });
}

}  // namespace

std::vector<float> signedDistances(const std::vector<char>& inside, const openvdb::Coord& size,
                                   const Vec3d& spacing) {
  const size_t count = inside.size();
  std::vector<float> toInside(count), toOutside(count);
  for (size_t i = 0; i < count; ++i)
    toInside[i] = inside[i] ? 0 : kFarSquared, toOutside[i] = inside[i] ? kFarSquared : 0;
  squaredDistances(toInside, size, spacing);
  squaredDistances(toOutside, size, spacing);
  for (size_t i = 0; i < count; ++i)
    toInside[i] = inside[i] ? std::sqrt(toOutside[i]) : -std::sqrt(toInside[i]);
  return toInside;
}

}  // namespace slicemorph
