#include "engine/numerics/distance_transform.h"

#include <tbb/parallel_for.h>

#include <cmath>
#include <limits>

namespace slicemorph {
namespace {

constexpr float kFar = 1e20f;

/// Squared distances along one line of `n` values, `stride` apart: the lower envelope of parabolas.
class Line {
 public:
  explicit Line(int n) : f_(size_t(n)), at_(size_t(n)), border_(size_t(n) + 1) {}

  void transform(float* values, size_t stride, int n, float spacing) {
    const float unit = spacing * spacing;
    int k = -1;
    for (int q = 0; q < n; ++q) {
      f_[size_t(q)] = values[size_t(q) * stride];
      if (f_[size_t(q)] >= kFar) continue;
      double s = -std::numeric_limits<double>::infinity();
      while (k >= 0) {
        const int v = at_[size_t(k)];
        s = ((double(f_[size_t(q)]) + double(unit) * q * q) -
             (double(f_[size_t(v)]) + double(unit) * v * v)) /
            (2.0 * unit * (q - v));
        if (s > border_[size_t(k)]) break;
        --k;
      }
      if (k < 0) s = -std::numeric_limits<double>::infinity();
      ++k;
      at_[size_t(k)] = q, border_[size_t(k)] = s,
      border_[size_t(k) + 1] = std::numeric_limits<double>::infinity();
    }
    if (k < 0) return;
    int j = 0;
    for (int q = 0; q < n; ++q) {
      while (border_[size_t(j) + 1] < q) ++j;
      const float d = float(q - at_[size_t(j)]);
      values[size_t(q) * stride] = unit * d * d + f_[size_t(at_[size_t(j)])];
    }
  }

 private:
  std::vector<float> f_;
  std::vector<int> at_;
  std::vector<double> border_;
};

/// Squared distances to the voxels that are 0.
void squaredDistances(std::vector<float>& d, const openvdb::Coord& n, const Vec3d& spacing) {
  const size_t row = size_t(n[0]), plane = row * size_t(n[1]);
  tbb::parallel_for(0, n[2], [&](int k) {
    Line x(n[0]), y(n[1]);
    float* slice = &d[size_t(k) * plane];
    for (int j = 0; j < n[1]; ++j) x.transform(slice + size_t(j) * row, 1, n[0], float(spacing[0]));
    for (int i = 0; i < n[0]; ++i) y.transform(slice + i, row, n[1], float(spacing[1]));
  });
  tbb::parallel_for(0, n[1], [&](int j) {
    Line z(n[2]);
    for (int i = 0; i < n[0]; ++i)
      z.transform(&d[size_t(j) * row + size_t(i)], plane, n[2], float(spacing[2]));
  });
}

}  // namespace

std::vector<float> signedDistances(const std::vector<char>& inside, const openvdb::Coord& size,
                                   const Vec3d& spacing) {
  const size_t count = inside.size();
  std::vector<float> toInside(count), toOutside(count);
  for (size_t i = 0; i < count; ++i) toInside[i] = inside[i] ? 0 : kFar, toOutside[i] = inside[i] ? kFar : 0;
  squaredDistances(toInside, size, spacing);
  squaredDistances(toOutside, size, spacing);
  for (size_t i = 0; i < count; ++i)
    toInside[i] = inside[i] ? std::sqrt(toOutside[i]) : -std::sqrt(toInside[i]);
  return toInside;
}

}  // namespace slicemorph
