#include "engine/rebuild/local_block.h"

#include "engine/numerics/catmull_rom.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace slicemorph {

template <typename Real>
void LocalBlock<Real>::reset(const openvdb::BBoxd& points, int channels) {
  low_ = openvdb::Coord::floor(points.min()).offsetBy(-1);
  size_ = openvdb::Coord::floor(points.max()).offsetBy(3) - low_;
  count_ = size_t(size_[0]) * size_t(size_[1]) * size_t(size_[2]);
  values_.resize(count_ * size_t(channels));
  active_.resize(count_);
  any_ = false;
  uniform_ = true;
}

template <typename Real>
typename LocalBlock<Real>::Corner LocalBlock<Real>::cornerOf(const Vec3d& at) const {
  const openvdb::Coord c = openvdb::Coord::floor(at);
  return {index(c), {Real(at[0] - c[0]), Real(at[1] - c[1]), Real(at[2] - c[2])}};
}

template <typename Real>
bool LocalBlock<Real>::active(const Vec3d& at) const {
  const size_t y = size_t(size_[2]), x = y * size_t(size_[1]);
  const char* a = &active_[cornerOf(at).index];
  return a[0] | a[1] | a[y] | a[y + 1] | a[x] | a[x + 1] | a[x + y] | a[x + y + 1];
}

template <typename Real>
Real LocalBlock<Real>::linear(const Vec3d& at, int channel) const {
  const Corner corner = cornerOf(at);
  const size_t y = size_t(size_[2]), x = y * size_t(size_[1]);
  const Real* v = &values_[size_t(channel) * count_ + corner.index];
  const auto [fx, fy, fz] = corner.fraction;
  const auto mix = [](Real a, Real b, Real f) { return a + f * (b - a); };
  return mix(mix(mix(v[0], v[1], fz), mix(v[y], v[y + 1], fz), fy),
             mix(mix(v[x], v[x + 1], fz), mix(v[x + y], v[x + y + 1], fz), fy), fx);
}

template <typename Real>
Real LocalBlock<Real>::linearAmongActive(const Vec3d& at, Real value[3]) const {
  const Corner corner = cornerOf(at);
  const size_t y = size_t(size_[2]), x = y * size_t(size_[1]);
  Real share = 0;
  value[0] = value[1] = value[2] = 0;
  for (int n = 0; n < 8; ++n) {
    const size_t i = corner.index + (n & 1 ? x : 0) + (n & 2 ? y : 0) + (n & 4 ? 1 : 0);
    if (!active_[i]) continue;
    Real weight = 1;
    for (int axis = 0; axis < 3; ++axis)
      weight *= n >> axis & 1 ? corner.fraction[axis] : 1 - corner.fraction[axis];
    for (int channel = 0; channel < 3; ++channel)
      value[channel] += weight * values_[size_t(channel) * count_ + i];
    share += weight;
  }
  for (int channel = 0; channel < 3 && share > 0; ++channel) value[channel] /= share;
  return share;
}

template <typename Real>
Real LocalBlock<Real>::cubic(const Vec3d& at, int channel) const {
  const Corner corner = cornerOf(at);
  const size_t y = size_t(size_[2]), x = y * size_t(size_[1]);
  const Real* v = &values_[size_t(channel) * count_ + corner.index] - x - y - 1;
  Real w[3][4];
  for (int axis = 0; axis < 3; ++axis) {
    const std::array<double, 4> weights = catmullRomWeights(double(corner.fraction[axis]));
    for (int i = 0; i < 4; ++i) w[axis][i] = Real(weights[size_t(i)]);
  }
  Real row[4] = {0, 0, 0, 0}, low[4], high[4];
  for (int i = 0; i < 4; ++i) low[i] = high[i] = v[i];
  for (int a = 0; a < 4; ++a)
    for (int b = 0; b < 4; ++b) {
      const Real* p = v + size_t(a) * x + size_t(b) * y;
      const Real weight = w[0][a] * w[1][b];
      for (int i = 0; i < 4; ++i) {
        row[i] += weight * p[i];
        low[i] = std::min(low[i], p[i]);
        high[i] = std::max(high[i], p[i]);
      }
    }
  const Real sum = row[0] * w[2][0] + row[1] * w[2][1] + row[2] * w[2][2] + row[3] * w[2][3];
  const Real least = std::min(std::min(low[0], low[1]), std::min(low[2], low[3]));
  const Real most = std::max(std::max(high[0], high[1]), std::max(high[2], high[3]));
  return std::min(std::max(sum, least), most);
}

template class LocalBlock<float>;
template class LocalBlock<double>;

}  // namespace slicemorph
