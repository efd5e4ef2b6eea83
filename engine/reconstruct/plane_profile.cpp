#include "engine/reconstruct/plane_profile.h"

#include <algorithm>
#include <cmath>
#include <cstdint>

namespace slicemorph {

namespace {

constexpr double kHeldPixels = 1.5;  // on both sides of a contour: value and slope
constexpr int kIterations = 80;
constexpr double kEnough = 1e-6;  // of the residual's square

double dot(const std::vector<float>& a, const std::vector<float>& b) {
  double sum = 0;
  for (size_t i = 0; i < a.size(); ++i) sum += double(a[i]) * b[i];
  return sum;
}

}  // namespace

std::vector<float> planeProfile(const PlaneImage& image, const std::vector<float>& slopes, double reach) {
  std::vector<float> values(image.distance.size());
  for (size_t n = 0; n < values.size(); ++n) values[n] = image.distance[n] * slopes[image.nearest[n]];
  std::vector<std::uint32_t> active;
  for (int j = 2; j < image.height - 2; ++j)
    for (int i = 2; i < image.width - 2; ++i) {
      const size_t n = size_t(j) * image.width + i;
      const double d = std::abs(image.distance[n]);
      if (d > kHeldPixels * image.pixel && d < reach) active.push_back(std::uint32_t(n));
    }
  // The biharmonic operator of the plane.
  const auto bending = [w = image.width](const float* v) {
    return 20 * v[0] - 8 * (v[-1] + v[1] + v[-w] + v[w]) + 2 * (v[-w - 1] + v[-w + 1] + v[w - 1] + v[w + 1]) +
           v[-2] + v[2] + v[-2 * w] + v[2 * w];
  };
  std::vector<float> r(active.size()), product(active.size()), direction(values.size(), 0.0f);
  for (size_t k = 0; k < active.size(); ++k) direction[active[k]] = r[k] = -bending(&values[active[k]]);
  double rr = dot(r, r);
  const double enough = kEnough * rr;
  for (int step = 0; step < kIterations && rr > enough; ++step) {
    double bend = 0;
    for (size_t k = 0; k < active.size(); ++k) {
      product[k] = bending(&direction[active[k]]);
      bend += double(product[k]) * direction[active[k]];
    }
    if (!(bend > 0)) break;
    const float alpha = float(rr / bend);
    for (size_t k = 0; k < active.size(); ++k) {
      values[active[k]] += alpha * direction[active[k]];
      r[k] -= alpha * product[k];
    }
    const double before = rr;
    rr = dot(r, r);
    const float beta = float(rr / before);
    for (size_t k = 0; k < active.size(); ++k) direction[active[k]] = r[k] + beta * direction[active[k]];
  }
  return values;
}

}  // namespace slicemorph
