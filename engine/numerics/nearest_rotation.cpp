#include "engine/numerics/nearest_rotation.h"

#include <Eigen/Core>
#include <Eigen/LU>
#include <Eigen/SVD>

#include <cmath>

namespace slicemorph {

namespace {

/// The rotation by a vector of axis times angle, from its quaternion.
Mat3d turnedBy(const Vec3d& vector) {
  const double angle = vector.length(), half = 0.5 * angle;
  const double share = angle > 1e-8 ? std::sin(half) / angle : 0.5;
  const double w = std::cos(half), x = share * vector[0], y = share * vector[1], z = share * vector[2];
  return Mat3d(1 - 2 * (y * y + z * z), 2 * (x * y - z * w), 2 * (x * z + y * w), 2 * (x * y + z * w),
               1 - 2 * (x * x + z * z), 2 * (y * z - x * w), 2 * (x * z - y * w), 2 * (y * z + x * w),
               1 - 2 * (x * x + y * y));
}

}  // namespace

Mat3d nearestRotation(const Mat3d& s) {
  Eigen::Matrix3d matrix;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) matrix(r, c) = s(r, c);
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(matrix, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Eigen::Matrix3d u = svd.matrixU();
  if ((u * svd.matrixV().transpose()).determinant() < 0) u.col(2) = -u.col(2);
  const Eigen::Matrix3d nearest = u * svd.matrixV().transpose();
  Mat3d rotation;
  for (int r = 0; r < 3; ++r)
    for (int c = 0; c < 3; ++c) rotation(r, c) = nearest(r, c);
  return rotation;
}

Mat3d nearestRotation(const Mat3d& s, const Mat3d& start) {
  // With M = R^T S, trace((R exp [w])^T S) = trace M + w . a - w^T (trace(M) I - sym M) w / 2 + ..., a twice the axial
  // vector of M's skew part. At the maximum a is 0 and the matrix in brackets is positive definite.
  constexpr int kMostSteps = 8;
  constexpr double kSmall = 1e-7;  // radians; steps shrink by squares, so that the last one is exact
  constexpr double kFar = 1;       // radians
  Mat3d r = start;
  for (int step = 0; step < kMostSteps; ++step) {
    const Mat3d m = r.transpose() * s;
    const Vec3d axial(m(2, 1) - m(1, 2), m(0, 2) - m(2, 0), m(1, 0) - m(0, 1));
    const double xx = m(1, 1) + m(2, 2), yy = m(0, 0) + m(2, 2), zz = m(0, 0) + m(1, 1);
    const double xy = -0.5 * (m(0, 1) + m(1, 0)), xz = -0.5 * (m(0, 2) + m(2, 0)),
                 yz = -0.5 * (m(1, 2) + m(2, 1));
    const Vec3d x(yy * zz - yz * yz, xz * yz - xy * zz, xy * yz - xz * yy);
    const double determinant = xx * x[0] + xy * x[1] + xz * x[2];
    const double size = xx + yy + zz, smallest = 1e-6 * size * size * size;
    if (!(xx > 0) || !(xx * yy - xy * xy > 0) || !(determinant > smallest)) break;
    const Vec3d y(x[1], xx * zz - xz * xz, xy * xz - xx * yz), z(x[2], y[2], xx * yy - xy * xy);
    const Vec3d turn = Vec3d(x.dot(axial), y.dot(axial), z.dot(axial)) / determinant;
    const double angle = turn.length();
    if (!(angle < kFar)) break;
    r = r * turnedBy(turn);
    if (angle < kSmall) return r;
  }
  return nearestRotation(s);
}

}  // namespace slicemorph
