#include "engine/volume/color_sampler.h"

#include <cmath>

namespace slicemorph {

namespace {

using openvdb::Coord;
using openvdb::Vec3s;

/// Trilinear weights below this are rounding errors.
constexpr double kLeastWeight = 1e-6;
/// Radius, in voxels, of the search for the nearest colour: one more than the half width of a narrow band.
constexpr int kReach = 4;

}  // namespace

bool isColor(const Vec3s& color) {
  return std::isfinite(color[0]) && std::isfinite(color[1]) && std::isfinite(color[2]);
}

void ColorMean::add(const Vec3s& color, double weight) {
  if (sum_ == 0) first_ = Vec3d(color);
  more_ += weight * (Vec3d(color) - first_);
  sum_ += weight;
}

std::optional<Vec3s> ColorMean::value() const {
  if (!(sum_ > 0)) return std::nullopt;
  return Vec3s(first_ + more_ / sum_);
}

ColorMean ColorSampler::between(const Vec3d& index) const {
  const Coord base = Coord::floor(index);
  const Vec3d rest = index - base.asVec3d();
  ColorMean mean;
  for (int n = 0; n < 8; ++n) {
    const Coord corner(n & 1, n >> 1 & 1, n >> 2);
    double weight = 1;
    for (int d = 0; d < 3; ++d) weight *= corner[d] ? rest[d] : 1 - rest[d];
    Vec3s color;
    if (weight > kLeastWeight && values_.probeValue(base + corner, color) && isColor(color))
      mean.add(color, weight);
  }
  return mean;
}

std::optional<Vec3s> ColorSampler::nearest(const Vec3d& index) const {
  std::optional<Vec3s> result;
  double least = kReach * kReach;
  const Coord middle = Coord::round(index);
  for (auto c = openvdb::CoordBBox(middle.offsetBy(-kReach), middle.offsetBy(kReach)).begin(); c; ++c) {
    const double squared = ((*c).asVec3d() - index).lengthSqr();
    Vec3s color;
    if (squared >= least || !values_.probeValue(*c, color) || !isColor(color)) continue;
    result = color, least = squared;
  }
  return result;
}

std::optional<Vec3s> ColorSampler::at(const Vec3d& world) const {
  const Vec3d index = toIndex(world);
  const std::optional<Vec3s> color = between(index).value();
  return color ? color : nearest(index);
}

}  // namespace slicemorph
