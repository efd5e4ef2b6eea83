#include "engine/spine/chart.h"

#include <cmath>

namespace slicemorph {

Vec3d rotationVector(const Mat3d& m) {
  // Through the quaternion's largest component: exact up to turns of 180 degrees.
  const double t[4] = {1 + m(0, 0) + m(1, 1) + m(2, 2), 1 + m(0, 0) - m(1, 1) - m(2, 2),
                       1 - m(0, 0) + m(1, 1) - m(2, 2), 1 - m(0, 0) - m(1, 1) + m(2, 2)};
  int k = 0;
  for (int i = 1; i < 4; ++i)
    if (t[i] > t[k]) k = i;
  const double s = 0.5 / std::sqrt(t[k]);
  const Vec3d antisymmetric(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
  double w;
  Vec3d v;
  if (k == 0) {
    w = 0.25 / s;
    v = antisymmetric * s;
  } else {
    const int i = k - 1;
    w = antisymmetric[i] * s;
    for (int j = 0; j < 3; ++j) v[j] = i == j ? 0.25 / s : (m(i, j) + m(j, i)) * s;
  }
  if (w < 0) w = -w, v = -v;
  const double length = v.length();
  if (length < 1e-12) return 2.0 * v;
  return v * (2.0 * std::atan2(length, w) / length);
}

Mat3d rotationFromVector(const Vec3d& v) {
  const double angle = v.length();
  if (angle < 1e-14) return Mat3d::identity();
  const Vec3d k = v / angle;
  const double c = std::cos(angle), s = std::sin(angle), d = 1 - c;
  return Mat3d(c + k[0] * k[0] * d, k[0] * k[1] * d - k[2] * s, k[0] * k[2] * d + k[1] * s,
               k[1] * k[0] * d + k[2] * s, c + k[1] * k[1] * d, k[1] * k[2] * d - k[0] * s,
               k[2] * k[0] * d - k[1] * s, k[2] * k[1] * d + k[0] * s, c + k[2] * k[2] * d);
}

Chart blendCharts(const std::vector<Chart>& charts, const Weights& weights) {
  size_t heaviest = 0;
  for (size_t k = 1; k < charts.size(); ++k)
    if (weights[k] > weights[heaviest]) heaviest = k;
  Chart result;
  result.center = result.scale = Vec3d(0.0);
  result.axes = charts[heaviest].axes;
  for (size_t k = 0; k < charts.size(); ++k) {
    result.center += weights[k] * charts[k].center;
    result.scale += weights[k] * charts[k].scale;
  }
  for (int i = 0; i < 30; ++i) {
    Vec3d step(0.0);
    for (size_t k = 0; k < charts.size(); ++k)
      if (weights[k] > 0) step += weights[k] * rotationVector(result.axes.transpose() * charts[k].axes);
    result.axes = result.axes * rotationFromVector(step);
    if (step.length() < 1e-14) break;
  }
  return result;
}

}  // namespace slicemorph
